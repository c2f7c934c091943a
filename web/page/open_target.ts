import type { Source } from "../stream/index.ts";
import type { Target } from "./volume_page.ts";

/** Where the address of the page points. */
export function openTarget(volume: string | undefined, src: string | undefined): Target {
  const name = volume ?? src ?? "";
  return { name, source: () => ({ name }) as Source };
}
