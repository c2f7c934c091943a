import type { AbsolutePath, AsyncReadable, RangeQuery } from "zarrita";
import { ZarrError } from "./image_axes.ts";
import { maxMetadataBytes, ZarrHost } from "./zarr_host.ts";

/** The files of a Zarr hierarchy. A file that does not exist is undefined. */
export interface ZarrSource extends AsyncReadable {
  /** The number of requested files that do not exist. */
  absent: number;
  /** Larger files, or parts of them, are refused (bytes). */
  maxBytes: number;
}

/** The files of a folder of this device, by their paths: "brain.zarr/zarr.json". */
export type FilesByPath = ReadonlyMap<string, Blob>;

/** The scheme of addresses of folders of this device: "files:/brain.zarr". */
const scheme = "files:";

/** The address of a folder among files of this device. Its path may be empty. */
export function addressOfFolder(path: string): string {
  return `${scheme}/${path.split("/").map(encodeURIComponent).join("/")}`;
}

/** The address, or the path of a folder of this device, for messages. */
export function shownAddress({ protocol, pathname, href }: URL): string {
  return protocol === scheme ? decodeURIComponent(pathname.replace(/^\/+/, "")) : href;
}

/** The files at an address. `files`: those of this device. */
export function zarrSource(base: URL, files: FilesByPath | undefined): ZarrSource {
  return base.protocol === scheme ? new ZarrFiles(base, files ?? new Map()) : new ZarrHost(base);
}

class ZarrFiles implements ZarrSource {
  readonly #folder: string;
  readonly #files: FilesByPath;
  absent = 0;
  maxBytes = maxMetadataBytes;

  constructor(base: URL, files: FilesByPath) {
    this.#folder = decodeURIComponent(base.pathname);
    this.#files = files;
  }

  get(key: AbsolutePath): Promise<Uint8Array | undefined> {
    return this.#read(key, (file) => file);
  }

  getRange(key: AbsolutePath, range: RangeQuery): Promise<Uint8Array | undefined> {
    return this.#read(key, (file) =>
      "suffixLength" in range
        ? file.slice(Math.max(0, file.size - range.suffixLength))
        : file.slice(range.offset, range.offset + range.length),
    );
  }

  async #read(key: AbsolutePath, part: (file: Blob) => Blob): Promise<Uint8Array | undefined> {
    const path = `${this.#folder}${key}`.replace(/\/{2,}/g, "/").replace(/^\//, "");
    const file = this.#files.get(path);
    if (!file) {
      ++this.absent;
      return undefined;
    }
    const wanted = part(file);
    if (wanted.size > this.maxBytes) {
      throw new ZarrError(
        `${path}: expected at most ${this.maxBytes} bytes, found ${wanted.size}: the file is damaged`,
      );
    }
    return new Uint8Array(await wanted.arrayBuffer());
  }
}
