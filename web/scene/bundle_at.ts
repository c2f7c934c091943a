import { FileSource, type SourceOptions } from "../stream/file_source.ts";
import { servedPath } from "./scene_name.ts";
import { ServedBundle } from "./served_bundle.ts";

/**
 * The bundle at a URL: `…/v1/scenes/NAME` is a scene of an Isosplat server, any other URL is the file of a
 * bundle. The query of a scene's URL is added to every request, as signed links require.
 */
export function bundleAt(url: URL, options: SourceOptions = {}): FileSource {
  const served = servedScene(url);
  if (!served) return new FileSource(url.href, options);
  const query = url.search.slice(1);
  return new ServedBundle({ ...options, ...served, ...(query && { query }) });
}

export function isServed(url: URL): boolean {
  return servedScene(url) !== undefined;
}

/** The server and the name of a scene of a server; undefined for all other URLs. */
function servedScene({ origin, pathname }: URL): { base: string; scene: string } | undefined {
  const [, folder, name] = servedPath.exec(pathname) ?? [];
  if (folder === undefined || name === undefined) return undefined;
  try {
    return { base: origin + folder, scene: decodeURIComponent(name) };
  } catch {
    return undefined; // a % that is not a valid escape
  }
}
