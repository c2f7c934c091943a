/** Bytes that are collected before they become a Blob, which the browser may keep on disk. */
const partBytes = 16 << 20;

/** Collects the store that a build writes, as a Blob. The header is written last, at offset 0. */
export class StoreParts {
  #header: Uint8Array = new Uint8Array();
  readonly #parts: Blob[] = [];
  #pending: Uint8Array[] = [];
  #pendingBytes = 0;

  write(offset: number, bytes: Uint8Array): void {
    if (offset === 0) {
      this.#header = bytes;
      return;
    }
    this.#pending.push(bytes);
    this.#pendingBytes += bytes.byteLength;
    if (this.#pendingBytes >= partBytes) this.#flush();
  }

  /** The whole store. */
  blob(): Blob {
    this.#flush();
    return new Blob([this.#header as BlobPart, ...this.#parts]);
  }

  #flush(): void {
    this.#parts.push(new Blob(this.#pending as BlobPart[]));
    this.#pending = [];
    this.#pendingBytes = 0;
  }
}
