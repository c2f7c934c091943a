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
  /** The parts of each owner, by offset. */
  readonly #byOwner = new Map<object, Map<number, Part>>();
  #bytes = 0;

  constructor(limit: number) {
    this.#limit = limit;
  }

  get bytes(): number {
    return this.#bytes;
  }

  /** A copy of a range of the owner's store; undefined if it is not kept in one part. */
  take(owner: object, offset: number, bytes: number): Uint8Array | undefined {
    const part = this.#partWith(owner, offset, bytes);
    if (!part) return undefined;
    this.#parts.delete(part);
    this.#parts.add(part);
    const at = offset - part.offset;
    return part.bytes.slice(at, at + bytes);
  }

  /** Whether a range of the owner's store is kept in one part. */
  has(owner: object, offset: number, bytes: number): boolean {
    return this.#partWith(owner, offset, bytes) !== undefined;
  }

  /** Keeps a copy. */
  keep(owner: object, offset: number, bytes: Uint8Array): void {
    if (bytes.length > this.#limit || this.has(owner, offset, bytes.length)) return;
    const part = { owner, offset, bytes: bytes.slice() };
    const own = this.#byOwner.get(owner) ?? new Map<number, Part>();
    const shorter = own.get(offset);
    if (shorter) this.#drop(shorter);
    this.#byOwner.set(owner, own.set(offset, part));
    this.#parts.add(part);
    this.#bytes += bytes.length;
    for (const oldest of this.#parts) {
      if (this.#bytes <= this.#limit) break;
      this.#drop(oldest);
    }
  }

  forget(owner: object): void {
    for (const part of [...(this.#byOwner.get(owner)?.values() ?? [])]) this.#drop(part);
  }

  clear(): void {
    this.#parts.clear();
    this.#byOwner.clear();
    this.#bytes = 0;
  }

  #partWith(owner: object, offset: number, bytes: number): Part | undefined {
    const own = this.#byOwner.get(owner);
    const covers = (part: Part): boolean =>
      part.offset <= offset && offset + bytes <= part.offset + part.bytes.length;
    const same = own?.get(offset);
    if (same && covers(same)) return same;
    for (const part of own?.values() ?? []) if (covers(part)) return part;
    return undefined;
  }

  #drop(part: Part): void {
    this.#parts.delete(part);
    this.#bytes -= part.bytes.length;
    const own = this.#byOwner.get(part.owner);
    own?.delete(part.offset);
    if (own?.size === 0) this.#byOwner.delete(part.owner);
  }
}
