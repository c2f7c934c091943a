import type { Core } from "../core/core.ts";
import { BlobSource } from "../stream/blob_source.ts";
import type { SourceOptions } from "../stream/file_source.ts";
import type { Source } from "../stream/source.ts";
import { joined, Traffic, transfer, transferWhole } from "../stream/transfer.ts";
import { StreamError } from "../stream/types.ts";
import { AddressedStores, isAddress } from "./addressed_stores.ts";
import { Bundle, type BundleFile } from "./bundle.ts";
import { bundleAt, isServed } from "./bundle_at.ts";
import { BundledSource } from "./bundled_source.ts";
import { sceneError } from "./member.ts";
import { parseScene } from "./parse_scene.ts";
import { maxSceneBytes, type SceneDocument } from "./scene_document.ts";
import { isBundleName, isDocumentName } from "./scene_name.ts";
import { ServedBundle, type ServedSceneOptions } from "./served_bundle.ts";

/** A scene that has been read: its document, and the bytes of its stores. */
export interface OpenedScene {
  readonly document: SceneDocument;
  /** The store with this path or address in the document. Throws a StreamError if the address is invalid. */
  source(path: string): Source;
  /** Fetches the first parts of several stores with few requests, if the stores are in bundles. */
  fetchFirst(paths: readonly string[]): Promise<void>;
}

/** The origin of a scene. */
export interface SceneSource {
  /** For messages. */
  readonly name: string;
  /** Reads the scene, but not its stores. Rejects with a StreamError or the signal's reason. */
  open(core: Core, signal: AbortSignal): Promise<OpenedScene>;
}

/**
 * A scene at an address. `…/v1/scenes/NAME` is a scene of an Isosplat server. A path that ends with `.json` is a
 * document. Any other address is a bundle on a host that answers HTTP Range requests. The headers and the query of
 * `options` are not sent to other origins.
 */
export function sceneAt(address: string, options: SourceOptions = {}): SceneSource {
  const page = typeof location === "undefined" ? undefined : location.href;
  const url = new URL(address, page);
  const isDocument = /\.json$/i.test(url.pathname) && !isServed(url);
  if (!isDocument) return bundleScene(bundleAt(url, options));
  return { name: url.href, open: (core, signal) => openDocument(core, url, options, signal) };
}

/** A scene of an Isosplat server. */
export function servedScene(options: ServedSceneOptions): SceneSource {
  return bundleScene(new ServedBundle(options));
}

/**
 * A scene of a static site, which `isosplat publish` writes. `catalog`: the address of its `catalog.json`, whose
 * `scenes` name the file of each bundle.
 */
export function publishedScene({
  catalog,
  scene,
}: {
  catalog: string;
  scene: string;
}): SceneSource {
  const page = typeof location === "undefined" ? undefined : location.href;
  const url = new URL(catalog, page).href;
  return {
    name: scene,
    open: async (core, signal) => {
      const bytes = await transferWhole(url, {}, new Traffic(), signal);
      const file = fileOf(new TextDecoder().decode(bytes), scene);
      if (file !== undefined) return sceneAt(new URL(file, url).href).open(core, signal);
      throw new StreamError("not-found", `${url}: has no scene ${scene}`);
    },
  };
}

/** The file of a scene in a site's catalog. */
function fileOf(catalog: string, scene: string): string | undefined {
  let scenes: unknown[] = [];
  try {
    const { scenes: found } = JSON.parse(catalog) as { scenes?: unknown };
    if (Array.isArray(found)) scenes = found;
  } catch {} // an invalid catalog counts as one without scenes
  const found = scenes.find((each) => (each as { name?: unknown } | null)?.name === scene) as
    | { file?: unknown }
    | undefined;
  return typeof found?.file === "string" ? found.file : undefined;
}

/** A file of this device. */
export interface SceneFile {
  /** A relative path with "/" as separator, such as "head/scene.json". */
  path: string;
  file: Blob;
}

/** A scene in files of this device: a bundle, or a document with its stores. Null if the files contain no scene. */
export function sceneOfFiles(files: readonly SceneFile[]): SceneSource | null {
  const bundle = files.find(({ path }) => isBundleName(path));
  if (bundle) return bundleScene(new BlobSource(bundle.file, nameOf(bundle.path)));
  const document = files.find(({ path }) => isDocumentName(path));
  if (!document) return null;
  return {
    name: nameOf(document.path),
    open: (core, signal) => openFiles(core, document, files, signal),
  };
}

/** A scene in a bundle. */
export function bundleScene(file: BundleFile): SceneSource {
  return {
    name: file.name,
    open: async (core, signal) => {
      const bundle = new Bundle(file, core);
      const { scene } = await bundle.header(signal);
      const document = parseScene(scene);
      const layers = document.layers.length;
      return {
        document,
        source: (path) => new BundledSource(bundle, path, layers),
        fetchFirst: (paths) => bundle.fetchCoarse(paths, signal),
      };
    },
  };
}

async function openDocument(
  core: Core,
  url: URL,
  options: SourceOptions,
  signal: AbortSignal,
): Promise<OpenedScene> {
  const traffic = new Traffic();
  traffic.admittance = options;
  const parts: Uint8Array[] = [];
  let received = 0;
  await transfer(url.href, {}, traffic, signal, (part) => {
    received += part.length;
    if (received > maxSceneBytes) throw tooLarge("more");
    parts.push(part.slice());
  });
  const stores = new AddressedStores(core, url.href, url.origin, options);
  return {
    document: parseScene(joined(parts)),
    source: (path) => stores.source(path, url.href),
    fetchFirst: (paths) => stores.fetchFirst(paths, signal, url.href),
  };
}

function tooLarge(found: number | string): StreamError {
  return sceneError(`expected at most ${maxSceneBytes} bytes, found ${found}`);
}

async function openFiles(
  core: Core,
  { path: at, file: document }: SceneFile,
  files: readonly SceneFile[],
  signal: AbortSignal,
): Promise<OpenedScene> {
  if (document.size > maxSceneBytes) {
    throw tooLarge(document.size);
  }
  const folder = at.replace(/[^/]*$/, "");
  const scene = parseScene(new Uint8Array(await document.arrayBuffer()));
  const stores = new AddressedStores(core, nameOf(at));
  const paths = [...new Set(scene.layers.flatMap(({ stores }) => stores))];
  return {
    document: scene,
    source: (path) => {
      if (isAddress(path)) return stores.source(path);
      const hasName = (each: string) => nameOf(each) === nameOf(path);
      const named = files.filter((each) => hasName(each.path));
      // Files that were chosen one by one have no folders, so only their names distinguish them.
      const isOnly = named.length === 1 && paths.filter(hasName).length <= 1;
      const found =
        files.find((each) => each.path === folder + path) ?? (isOnly ? named[0] : undefined);
      if (found) return new BlobSource(found.file, nameOf(found.path));
      throw new StreamError(
        "not-found",
        named.length > 0
          ? `${nameOf(at)}: expected the store ${path} at its path, found its name more than once: drop the scene's folder`
          : `${nameOf(at)}: expected the store ${path} among the chosen files, found none: choose it too`,
      );
    },
    fetchFirst: (asked) => stores.fetchFirst(asked, signal),
  };
}

function nameOf(path: string): string {
  return path.replace(/^.*\//, "");
}
