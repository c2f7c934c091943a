/** Number of bytes that are collected before they become a Blob, which the browser may keep on disk. */
const partBytes = 16 << 20;

/** Collects bytes, which arrive in order, as a Blob. */
export class BlobParts {
  readonly #parts: Blob[] = [];
  #pending: Uint8Array[] = [];
  #pendingBytes = 0;

  add(bytes: Uint8Array): void {
    this.#pending.push(bytes);
    this.#pendingBytes += bytes.byteLength;
    if (this.#pendingBytes >= partBytes) this.#flush();
  }

  /** All bytes so far, after those of `first`. */
  blob(first: Uint8Array = new Uint8Array()): Blob {
    this.#flush();
    return new Blob([first as BlobPart, ...this.#parts]);
  }

  #flush(): void {
    this.#parts.push(new Blob(this.#pending as BlobPart[]));
    this.#pending = [];
    this.#pendingBytes = 0;
  }
}
