import { FileSource, type SourceOptions } from "./file_source.ts";
import { ServerSource } from "./server_source.ts";

const serverPath = /^(.*\/)v1\/volumes\/([^/]+)\/?$/;

/**
 * The source at a URL: `…/v1/volumes/NAME` is a volume of an Isosplat server, any other URL is the
 * file of a store. The query of a volume's URL is added to every request, as signed links require.
 * Undefined if the URL is wrong.
 */
export function sourceAt(url: URL, options: SourceOptions = {}): FileSource | undefined {
  const [, folder, name] = serverPath.exec(url.pathname) ?? [];
  if (folder === undefined || name === undefined) return new FileSource(url.href, options);
  const query = url.search.slice(1);
  try {
    return new ServerSource({
      ...options,
      base: url.origin + folder,
      volume: decodeURIComponent(name),
      ...(query && { query }),
    });
  } catch {
    return undefined; // a % that is not a valid escape
  }
}
