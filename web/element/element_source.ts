import { FileSource } from "../stream/file_source.ts";
import { ServerSource } from "../stream/server_source.ts";
import type { Source } from "../stream/source.ts";

const serverPath = /^(.*\/)v1\/volumes\/([^/]+)\/?$/;

/**
 * The source that an address names: `…/v1/volumes/NAME` is a volume of an Isosplat server, anything
 * else the file of a store. A query of the former is added to every request, as signed links need
 * it. `base`: the address of the document. Undefined if it is not an http or https address.
 */
export function sourceOf(src: string, base: string): Source | undefined {
  let url: URL;
  try {
    url = new URL(src, base);
  } catch {
    return undefined;
  }
  if (!/^https?:$/.test(url.protocol)) return undefined;
  const [, folder, name] = serverPath.exec(url.pathname) ?? [];
  if (folder === undefined || name === undefined) return new FileSource(url.href);
  const query = url.search.slice(1);
  try {
    return new ServerSource({
      base: url.origin + folder,
      volume: decodeURIComponent(name),
      ...(query && { query }),
    });
  } catch {
    return undefined; // a % that is not a valid escape
  }
}
