import { StreamError } from "../stream/types.ts";
import { fetchFile, nameAt, pathAt } from "./fetch_file.ts";
import type { InputFile } from "./files.ts";

export interface RemoteOptions {
  signal: AbortSignal;
  /** `bytes`: size of the whole file, if the host states it. */
  progress(name: string, received: number, bytes: number | undefined): void;
}

/**
 * A volume's file at an address, and the files that it names. The path of a file is the path of its address, so that
 * "../voxels.raw" in a header is resolved relative to the header. All files are on one host.
 */
export class RemoteFiles {
  readonly #address: URL;
  readonly #options: RemoteOptions;

  constructor(address: URL, options: RemoteOptions) {
    this.#address = address;
    this.#options = options;
  }

  /**
   * The file at the address. If `isKnown` returns true for its version, the body is not fetched,
   * and `file` is undefined.
   */
  async first(
    isKnown: (version: string) => boolean,
  ): Promise<{ file: InputFile | undefined; version: string | undefined }> {
    return this.#fetch(this.#address, isKnown);
  }

  /** A file that the volume names; undefined if there is none. */
  async find(path: string): Promise<InputFile | undefined> {
    const address = new URL(this.#address);
    address.pathname = path.split("/").map(encodeURIComponent).join("/");
    try {
      return (await this.#fetch(address)).file;
    } catch (error) {
      if (error instanceof StreamError && error.kind === "not-found") return undefined;
      throw error;
    }
  }

  async #fetch(address: URL, isKnown?: (version: string) => boolean) {
    const { signal, progress } = this.#options;
    const name = nameAt(address);
    const { file, version } = await fetchFile(address, {
      signal,
      progress: (received, bytes) => progress(name, received, bytes),
      ...(isKnown && { isKnown }),
    });
    const path = pathAt(address) || name;
    // Without a version, the key is random, so that no other file counts as the same.
    const key = version ? `${address.href} ${version}` : `unknown ${Math.random()}`;
    return { file: file && { path, file, version: key }, version };
  }
}
