import type { Core } from "../core/core.ts";
import type { SourceOptions } from "../stream/file_source.ts";
import type { Source } from "../stream/source.ts";
import { sourceAt } from "../stream/source_at.ts";
import { StreamError } from "../stream/types.ts";
import { Bundle } from "./bundle.ts";
import { bundleAt } from "./bundle_at.ts";
import { BundledSource } from "./bundled_source.ts";

/** Whether the path of a store is an absolute address. */
export function isAddress(path: string): boolean {
  return /^https?:\/\//i.test(path) && URL.canParse(path);
}

/**
 * The stores at the addresses in a scene's document: files, volumes of servers, and stores in bundles. The
 * fragment of an address is the path of the store in the bundle. The credentials in `options` are sent only to the
 * scene's own host.
 */
export class AddressedStores {
  readonly #core: Core;
  /** For messages. */
  readonly #scene: string;
  readonly #origin: string | undefined;
  readonly #options: SourceOptions;
  readonly #bundles = new Map<string, Bundle>();

  /** origin: that of the scene; undefined if it is a file of this device. */
  constructor(core: Core, scene: string, origin?: string, options: SourceOptions = {}) {
    this.#core = core;
    this.#scene = scene;
    this.#origin = origin;
    this.#options = options;
  }

  /** `base`: the address of the document; undefined if it has none. Throws a StreamError. */
  source(path: string, base?: string): Source {
    const url = URL.canParse(path, base) ? new URL(path, base) : undefined;
    const bundled = url && this.#bundled(url);
    if (bundled) return new BundledSource(bundled.bundle, bundled.path);
    const isReadable = url !== undefined && /^https?:$/.test(url.protocol);
    const source = isReadable ? sourceAt(url, this.#optionsOf(url)) : undefined;
    if (source) return source;
    throw new StreamError(
      "not-found",
      `${this.#scene}: expected stores at addresses of http or https, found ${path}`,
    );
  }

  /** Fetches the first parts of stores in bundles. */
  async fetchFirst(paths: readonly string[], signal: AbortSignal, base?: string): Promise<void> {
    const ofBundles = new Map<Bundle, string[]>();
    for (const path of paths) {
      const bundled = URL.canParse(path, base) && this.#bundled(new URL(path, base));
      if (!bundled) continue;
      ofBundles.set(bundled.bundle, [...(ofBundles.get(bundled.bundle) ?? []), bundled.path]);
    }
    await Promise.all(
      [...ofBundles].map(([bundle, ofBundle]) => bundle.fetchCoarse(ofBundle, signal)),
    );
  }

  /** Undefined if the address is not that of a store in a bundle. */
  #bundled(url: URL): { bundle: Bundle; path: string } | undefined {
    if (url.hash === "" || !/^https?:$/.test(url.protocol)) return undefined;
    const path = unescaped(url.hash.slice(1));
    const address = url.href.slice(0, url.href.indexOf("#"));
    let bundle = this.#bundles.get(address);
    bundle ??= new Bundle(bundleAt(new URL(address), this.#optionsOf(url)), this.#core);
    this.#bundles.set(address, bundle);
    return { bundle, path };
  }

  #optionsOf({ origin }: URL): SourceOptions {
    if (origin === this.#origin) return this.#options;
    const { longestSilence } = this.#options;
    return longestSilence === undefined ? {} : { longestSilence };
  }
}

function unescaped(text: string): string {
  try {
    return decodeURI(text);
  } catch {
    return text; // a % that is not a valid escape
  }
}
