import { FileSource } from "../stream/index.ts";
import { volumeSource } from "./site.ts";
import type { Target } from "./volume_page.ts";

/**
 * What the page's address refers to: a volume of its server or site, or a store on any host. Undefined
 * for everything else: see start.ts.
 */
export function openTarget(
  volume: string | undefined,
  src: string | undefined,
): Target | undefined {
  if (volume !== undefined) return { name: volume, source: () => volumeSource(volume) };
  const address = src === undefined ? undefined : storeAddress(src);
  return address && { name: fileName(address), source: () => new FileSource(address.href) };
}

/** Undefined if the text is not an address from which a store can be fetched. */
function storeAddress(text: string): URL | undefined {
  try {
    const address = new URL(text, location.href);
    return /^https?:$/.test(address.protocol) ? address : undefined;
  } catch {
    return undefined;
  }
}

function fileName(address: URL): string {
  const name = address.pathname.slice(address.pathname.lastIndexOf("/") + 1);
  try {
    return decodeURIComponent(name) || address.href;
  } catch {
    return name; // a % that is not a valid escape
  }
}
