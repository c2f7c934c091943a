import { FileSource } from "../stream/file_source.ts";
import { ServerSource } from "../stream/server_source.ts";
import type { Source } from "../stream/source.ts";

const serverPath = /^(.*\/)v1\/volumes\/([^/]+)\/?$/;

/**
 * The source at a URL: `…/v1/volumes/NAME` is a volume of an Isosplat server, any other URL is the
 * file of a store. The query of a volume's URL is added to every request, as signed links require.
 * `base`: the URL of the document. Undefined if it is not an http or https URL.
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
