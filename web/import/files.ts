import type { ImportFiles } from "./module.ts";
import type { InputFile } from "./types.ts";

/** Reads bytes of a Blob synchronously: FileReaderSync in workers. */
export type ReadBlob = (blob: Blob) => Uint8Array;

/** Headers are read in small pieces, so blocks of this size are cached. */
const blockBytes = 256 << 10;
const keptBlocks = 16;

/** The path with "." and empty parts left out; "" is the root. */
function normal(path: string): string {
  const parts: string[] = [];
  for (const part of path.split("/")) {
    if (part === "..") parts.pop();
    else if (part !== "" && part !== ".") parts.push(part);
  }
  return parts.join("/");
}

/** Files by their paths, and their bytes. If two files have the same path, the first is used. */
export class FileTable implements ImportFiles {
  readonly #files: Blob[] = [];
  readonly #byPath = new Map<string, number>();
  readonly #folders = new Map<string, Map<string, "f" | "d">>([["", new Map()]]);
  readonly #readBlob: ReadBlob;
  /** The most recently read blocks, the newest at the end. */
  readonly #blocks = new Map<string, Uint8Array>();
  /** Paths at which no file was found. */
  readonly missing = new Set<string>();

  constructor(files: readonly InputFile[], readBlob: ReadBlob) {
    this.#readBlob = readBlob;
    this.add(files);
  }

  add(files: readonly InputFile[]): void {
    for (const { path, file } of files) {
      const name = normal(path);
      if (name === "" || this.#byPath.has(name) || this.#folders.has(name)) continue;
      this.#byPath.set(name, this.#files.length);
      this.#files.push(file);
      this.#enter(name, "f");
    }
  }

  /** Replaces the bytes of an existing file by its decompressed bytes. */
  replace(path: string, content: Blob): void {
    const file = this.#byPath.get(normal(path));
    if (file === undefined) return;
    this.#files[file] = content;
    this.#blocks.clear();
  }

  /** Enters a name, and the folders that it is in. */
  #enter(path: string, kind: "f" | "d"): void {
    const cut = path.lastIndexOf("/");
    const folder = path.slice(0, Math.max(0, cut));
    if (!this.#folders.has(folder)) {
      this.#folders.set(folder, new Map());
      this.#enter(folder, "d");
    }
    this.#folders.get(folder)?.set(path.slice(cut + 1), kind);
  }

  find(path: string): number {
    const name = normal(path);
    const found = this.#byPath.get(name) ?? (this.#folders.has(name) ? -2 : -1);
    if (found === -1) this.missing.add(name);
    return found;
  }

  bytes(file: number): number {
    return this.#files[file]?.size ?? 0;
  }

  modified(file: number): number {
    return (this.#files[file] as File | undefined)?.lastModified ?? 0;
  }

  names(folder: string): string[] {
    const entries = this.#folders.get(normal(folder)) ?? new Map<string, string>();
    return [...entries].map(([name, kind]) => kind + name);
  }

  read(file: number, offset: number, into: Uint8Array): number {
    const blob = this.#files[file];
    if (!blob || offset >= blob.size) return 0;
    const count = Math.min(into.byteLength, blob.size - offset);
    if (count >= blockBytes) {
      into.set(this.#readBlob(blob.slice(offset, offset + count)));
      return count;
    }
    for (let done = 0; done < count; ) {
      const index = Math.floor((offset + done) / blockBytes);
      const inside = offset + done - index * blockBytes;
      const part = this.#block(file, blob, index).subarray(inside, inside + count - done);
      if (part.byteLength === 0) throw new Error("the file has become shorter");
      into.set(part, done);
      done += part.byteLength;
    }
    return count;
  }

  #block(file: number, blob: Blob, index: number): Uint8Array {
    const key = `${file}:${index}`;
    let block = this.#blocks.get(key);
    if (block) this.#blocks.delete(key);
    else block = this.#readBlob(blob.slice(index * blockBytes, (index + 1) * blockBytes));
    this.#blocks.set(key, block);
    const oldest = this.#blocks.keys().next();
    if (this.#blocks.size > keptBlocks && !oldest.done) this.#blocks.delete(oldest.value);
    return block;
  }
}
