import { BlobParts } from "../core/blob_parts.ts";

/** Collects the store that a build writes, as a Blob. The header is written last, at offset 0. */
export class StoreParts {
  #header: Uint8Array = new Uint8Array();
  readonly #rest = new BlobParts();

  write(offset: number, bytes: Uint8Array): void {
    if (offset === 0) this.#header = bytes;
    else this.#rest.add(bytes);
  }

  /** The whole store. */
  blob(): Blob {
    return this.#rest.blob(this.#header);
  }
}
