import { compiledOnce } from "../core/compile_asset.ts";
import { type CompiledModule, instantiate, type ModuleFactory } from "../core/instantiate.ts";

/** The files that the module reads: shared/bindings/wasm/import_host.h. */
export interface ImportFiles {
  /** The number of a file; −1: nothing has this path; −2: a folder. */
  find(path: string): number;
  bytes(file: number): number;
  /** In milliseconds since 1970; 0: unknown. */
  modified(file: number): number;
  /**
   * Fills `into`, or a part of it at the end of the file. Returns the number of bytes. Throws if
   * reading fails.
   */
  read(file: number, offset: number, into: Uint8Array): number;
  /** The entries of a folder: names, each after "f" (file) or "d" (folder). */
  names(folder: string): readonly string[];
}

/** The exports of isosplat-import.wasm: shared/bindings/wasm/import_api.h. */
export interface ImportModule {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(at: number): void;
  _isosplat_import_create(): number;
  _isosplat_import_destroy(importer: number): void;
  _isosplat_import_error(importer: number): number;
  _isosplat_import_status_name(status: number): number;
  _isosplat_import_result(importer: number): number;
  _isosplat_import_result_bytes(importer: number): number;
  _isosplat_import_detect(importer: number, path: number, bytes: number): number;
  _isosplat_import_packing(importer: number, path: number, bytes: number): number;
  _isosplat_import_choices(importer: number, path: number, bytes: number): number;
  _isosplat_import_open(importer: number, request: number, bytes: number): number;
  _isosplat_import_read_slices(importer: number, first: number, count: number): number;
}

const fetched = compiledOnce(
  "isosplat-import.wasm",
  () => new URL("../../build/wasm/web/isosplat-import.wasm", import.meta.url),
);

/** Compiles the module, once for all workers. `bytes`: of isosplat-import.wasm; default: fetched. */
export async function compileImport(bytes?: BufferSource): Promise<CompiledModule> {
  return bytes ? WebAssembly.compile(bytes) : fetched();
}

export async function instantiateImport(
  program: CompiledModule,
  files: ImportFiles,
): Promise<ImportModule> {
  const { default: factory } = await import("../../build/wasm/web/isosplat-import.js");
  const create = factory as (options: object) => Promise<unknown>;
  const withFiles: ModuleFactory = (options) => create({ ...options, files });
  return instantiate<ImportModule>(withFiles, program);
}
