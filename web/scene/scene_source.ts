import type { Core } from "../core/core.ts";
import { BlobSource } from "../stream/blob_source.ts";
import { FileSource, type SourceOptions } from "../stream/file_source.ts";
import type { Source } from "../stream/source.ts";
import { joined, Traffic, transfer } from "../stream/transfer.ts";
import { StreamError } from "../stream/types.ts";
import { Bundle, type BundleFile } from "./bundle.ts";
import { BundledSource } from "./bundled_source.ts";
import { sceneError } from "./member.ts";
import { parseScene } from "./parse_scene.ts";
import { maxSceneBytes, type SceneDocument } from "./scene_document.ts";
import { ServedBundle, type ServedSceneOptions } from "./served_bundle.ts";

/** A scene that has been read: its document, and the bytes of its stores. */
export interface OpenedScene {
  readonly document: SceneDocument;
  /** A store of the document, by its path or address there. Throws a StreamError for wrong addresses. */
  source(path: string): Source;
  /** Fetches the first parts of several stores with few requests, where the scene permits it. */
  fetchFirst(paths: readonly string[]): Promise<void>;
}

/** Where a scene comes from. */
export interface SceneSource {
  /** For messages. */
  readonly name: string;
  /** Reads the scene, but not its stores. Rejects with a StreamError or the signal's reason. */
  open(core: Core, signal: AbortSignal): Promise<OpenedScene>;
}

/**
 * A scene at an address: a document if the address's path ends with `.json`, otherwise a bundle, which the
 * host serves by HTTP Range requests. Stores of other origins get no headers and no query of `options`.
 */
export function sceneAt(address: string, options: SourceOptions = {}): SceneSource {
  const page = typeof location === "undefined" ? undefined : location.href;
  const url = new URL(address, page);
  if (!/\.json$/i.test(url.pathname)) return bundleScene(new FileSource(url.href, options));
  return { name: url.href, open: (_, signal) => openDocument(url, options, signal) };
}

/** A scene of an Isosplat server. */
export function servedScene(options: ServedSceneOptions): SceneSource {
  return bundleScene(new ServedBundle(options));
}

/** Files of this device: a bundle, or a document with its stores. Null: there is no scene among them. */
export function sceneOfFiles(files: readonly File[]): SceneSource | null {
  const bundle = files.find((file) => /\.isobundle$/i.test(file.name));
  if (bundle) return bundleScene(new BlobSource(bundle, bundle.name));
  const document = files.find((file) => /\.json$/i.test(file.name));
  if (!document) return null;
  return { name: document.name, open: () => openFiles(document, files) };
}

/** A scene in a bundle. */
export function bundleScene(file: BundleFile): SceneSource {
  return {
    name: file.name,
    open: async (core, signal) => {
      const bundle = new Bundle(file, core);
      const { scene } = await bundle.header(signal);
      return {
        document: parseScene(scene),
        source: (path) => new BundledSource(bundle, path),
        fetchFirst: (paths) => bundle.fetchCoarse(paths, signal),
      };
    },
  };
}

async function openDocument(
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
  return {
    document: parseScene(joined(parts)),
    source: (path) => {
      const store = addressOf(path, url);
      // Credentials are for the scene's own host.
      const { longestSilence } = options;
      const others = longestSilence === undefined ? {} : { longestSilence };
      return new FileSource(store.href, store.origin === url.origin ? options : others);
    },
    fetchFirst: async () => {},
  };
}

function tooLarge(found: number | string): StreamError {
  return sceneError(`expected at most ${maxSceneBytes} bytes, found ${found}`);
}

function addressOf(path: string, scene: URL): URL {
  const url = URL.canParse(path, scene.href) ? new URL(path, scene.href) : null;
  if (url && /^https?:$/.test(url.protocol)) return url;
  throw new StreamError(
    "not-found",
    `${scene.href}: expected stores at addresses of http or https, found ${path}`,
  );
}

async function openFiles(document: File, files: readonly File[]): Promise<OpenedScene> {
  if (document.size > maxSceneBytes) {
    throw tooLarge(document.size);
  }
  const folder = pathOf(document).replace(/[^/]*$/, "");
  return {
    document: parseScene(new Uint8Array(await document.arrayBuffer())),
    source: (path) => {
      const name = path.replace(/^.*\//, "");
      const found =
        files.find((file) => pathOf(file) === folder + path) ??
        files.find((file) => file.name === name);
      if (found) return new BlobSource(found, found.name);
      throw new StreamError(
        "not-found",
        `${document.name}: expected the store ${path} among the chosen files, found none: choose it too`,
      );
    },
    fetchFirst: async () => {},
  };
}

/** Below the folder that was chosen or dropped, if it was one. */
function pathOf(file: File): string {
  return file.webkitRelativePath || file.name;
}
