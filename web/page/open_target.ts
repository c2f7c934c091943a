import { FileSource, ServerSource } from "../stream/index.ts";
import type { Target } from "./volume_page.ts";

/** Where the address of the page points: a volume of its server, or a store on any host. */
export function openTarget(volume: string | undefined, src: string | undefined): Target {
  if (volume !== undefined) return { name: volume, source: () => new ServerSource({ volume }) };
  const address = new URL(src ?? "", location.href).href;
  return { name: fileName(address), source: () => new FileSource(address) };
}

function fileName(address: string): string {
  const path = new URL(address).pathname;
  return decodeURIComponent(path.slice(path.lastIndexOf("/") + 1)) || address;
}
