import type { Source } from "../stream/source.ts";
import { sourceAt } from "../stream/source_at.ts";

/** See sourceAt. `base`: the URL of the document. Undefined if `src` is not an http or https URL. */
export function sourceOf(src: string, base: string): Source | undefined {
  const url = URL.canParse(src, base) ? new URL(src, base) : undefined;
  return url && /^https?:$/.test(url.protocol) ? sourceAt(url) : undefined;
}
