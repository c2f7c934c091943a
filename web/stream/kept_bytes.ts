import { isHandheld } from "./device.ts";

interface Part {
  owner: object;
  offset: number;
  bytes: Uint8Array;
}

/** The limit of `KeptBytes` for the class of this device. */
export function defaultKeptBytes(): number {
  return (isHandheld() ? 32 : 128) * 1024 * 1024;
}

/**
 * Bytes of several stores as they arrived, so that a store that is opened again makes no requests. When the
 * limit is reached, the least recently used parts are dropped.
 */
export class KeptBytes {
  readonly #limit: number;
  /** The least recently used first. */
  readonly #parts = new Set<Part>();
  readonly #byOwner = new Map<object, Set<Part>>();
  #bytes = 0;

  constructor(limit: number) {
    this.#limit = limit;
  }

  get bytes(): number {
    return this.#bytes;
  }

  /** A copy of a range of the owner's store; undefined if it is not kept in one part. */
  take(owner: object, offset: number, bytes: number): Uint8Array | undefined {
    for (const part of this.#byOwner.get(owner) ?? []) {
      const at = offset - part.offset;
      if (at < 0 || at + bytes > part.bytes.length) continue;
      this.#parts.delete(part);
      this.#parts.add(part);
      return part.bytes.slice(at, at + bytes);
    }
    return undefined;
  }

  /** Keeps a copy. */
  keep(owner: object, offset: number, bytes: Uint8Array): void {
    if (bytes.length > this.#limit || this.take(owner, offset, bytes.length)) return;
    const part = { owner, offset, bytes: bytes.slice() };
    const own = this.#byOwner.get(owner) ?? new Set();
    this.#byOwner.set(owner, own.add(part));
    this.#parts.add(part);
    this.#bytes += bytes.length;
    for (const oldest of this.#parts) {
      if (this.#bytes <= this.#limit) break;
      this.#drop(oldest);
    }
  }

  forget(owner: object): void {
    for (const part of [...(this.#byOwner.get(owner) ?? [])]) this.#drop(part);
  }

  clear(): void {
    this.#parts.clear();
    this.#byOwner.clear();
    this.#bytes = 0;
  }

  #drop(part: Part): void {
    this.#parts.delete(part);
    this.#bytes -= part.bytes.length;
    const own = this.#byOwner.get(part.owner);
    own?.delete(part);
    if (own?.size === 0) this.#byOwner.delete(part.owner);
  }
}
