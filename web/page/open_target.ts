import { FileSource, StreamError } from "../stream/index.ts";
import { volumeSource } from "./site.ts";
import type { Target } from "./volume_page.ts";

/** What the page's address refers to: a volume of its server or site, or a store on any host. */
export function openTarget(volume: string | undefined, src: string | undefined): Target {
  if (volume !== undefined) return { name: volume, source: () => volumeSource(volume) };
  const text = src ?? "";
  const address = storeAddress(text);
  if (!address) {
    const message =
      `src=${text}: expected the http or https address of a store, such as ` +
      "https://example.org/head.isosplat; correct it in the address bar";
    return {
      name: text,
      source: () => {
        throw new StreamError("bad-address", message);
      },
    };
  }
  return { name: fileName(address), source: () => new FileSource(address.href) };
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
