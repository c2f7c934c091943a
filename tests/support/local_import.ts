import { openSync, readdirSync, readFileSync, readSync, statSync } from "node:fs";
import { join } from "node:path";
import type { CompiledModule } from "../../web/core/index.ts";
import {
  compileImport,
  FileTable,
  Importer,
  type InputFile,
  instantiateImport,
} from "../../web/import/index.ts";

const wasm = new URL("../../build/wasm/web/isosplat-import.wasm", import.meta.url);

/** The compiled import module. */
export function importProgram(): Promise<CompiledModule> {
  return compileImport(readFileSync(wasm));
}

/** A file on disk, or bytes, for FileReaderSync: it reads them like a Blob. */
class SyncBlob {
  readonly lastModified = 0;
  constructor(
    readonly read: (begin: number, end: number) => Uint8Array,
    readonly begin: number,
    readonly end: number,
  ) {}
  get size(): number {
    return this.end - this.begin;
  }
  slice(begin: number, end: number): SyncBlob {
    return new SyncBlob(this.read, this.begin + begin, Math.min(this.end, this.begin + end));
  }
}

export function fileOf(path: string, bytes: Uint8Array): InputFile {
  const blob = new SyncBlob((begin, end) => bytes.slice(begin, end), 0, bytes.byteLength);
  return { path, file: blob as unknown as Blob };
}

/** A file that begins with these bytes; all other bytes are 0. */
export function sparseFile(path: string, beginning: Uint8Array, size: number): InputFile {
  const read = (begin: number, end: number): Uint8Array => {
    const bytes = new Uint8Array(end - begin);
    bytes.set(beginning.subarray(begin, end));
    return bytes;
  };
  return { path, file: new SyncBlob(read, 0, size) as unknown as Blob };
}

/** The files of a folder and its subfolders, as if the content of the folder was dropped onto the page. */
export function filesOf(folder: string, inside = ""): InputFile[] {
  return readdirSync(join(folder, inside), { withFileTypes: true }).flatMap((entry) => {
    const path = inside ? `${inside}/${entry.name}` : entry.name;
    if (entry.isDirectory()) return filesOf(folder, path);
    const descriptor = openSync(join(folder, path), "r");
    const read = (begin: number, end: number): Uint8Array => {
      const bytes = new Uint8Array(end - begin);
      return bytes.subarray(0, readSync(descriptor, bytes, 0, bytes.byteLength, begin));
    };
    const blob = new SyncBlob(read, 0, statSync(join(folder, path)).size);
    return [{ path, file: blob as unknown as Blob }];
  });
}

/** An importer with these files, on this thread. */
export async function localImporter(
  program: CompiledModule,
  files: readonly InputFile[],
): Promise<Importer> {
  const table = new FileTable(files, (blob) => {
    const { read, begin, end } = blob as unknown as SyncBlob;
    return read(begin, end);
  });
  return new Importer(await instantiateImport(program, table));
}
