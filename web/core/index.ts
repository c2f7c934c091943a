/**
 * The core in WebAssembly, for Node and browsers:
 *
 *     const core = await loadCore();
 *     const store = core.openStore(bytes.subarray(0, maxHeaderBytes));
 *     for (const page of store.missingPages(0, isovalue)) store.addPage(page, …);
 *     for (const chunk of store.chunksFor(0, isovalue)) {
 *       const points = store.project(chunk, bytes.subarray(chunk.offset, …), isovalue);
 *     }
 *     store.close();
 */
import { Core } from "./core.ts";
import { fileBytes } from "./file_bytes.ts";
import { type CompiledModule, instantiate, type ModuleFactory } from "./instantiate.ts";
import type { CoreModule } from "./module.ts";

export { type ChunkShape, CoreError } from "./calls.ts";
export * from "./core.ts";
export { type CompiledModule, instantiate, type ModuleFactory } from "./instantiate.ts";
export type { CoreModule } from "./module.ts";
export { type Chunk, type Page, volumeRecord } from "./records.ts";
export { textAt } from "./text.ts";
export type { DecodedChunk, Points, Samples, StoreInfo, StoreMetadata, Triple } from "./types.ts";
export { failureOf, type WorkerFailure } from "./worker_failure.ts";

/** The module that provides the core: isosplat-core, or isosplat-renderer, which contains it. */
export interface CoreOptions {
  /** The bytes of isosplat-core.wasm. */
  wasmBinary?: Uint8Array;
  /** The address of isosplat-core.wasm. Default: beside its module. */
  url?: string;
  /** An existing instance with the functions of the core, such as one of isosplat-renderer. */
  module?: CoreModule;
  /** The compiled code of isosplat-renderer, to create another instance of it. */
  renderer?: CompiledModule;
}

/** Makes an instance of the core, in a browser, a worker, or Node (20.16 or newer). */
export async function loadCore(options: CoreOptions = {}): Promise<Core> {
  if (options.module) return new Core(options.module);
  if (options.renderer) {
    const { default: factory } = await import("../../build/wasm/web/isosplat-renderer.js");
    return new Core(await instantiate<CoreModule>(factory as ModuleFactory, options.renderer));
  }
  const { default: createModule } = await import("../../build/wasm/web/isosplat-core.js");
  const url = new URL("../../build/wasm/web/isosplat-core.wasm", import.meta.url);
  const wasmBinary = options.wasmBinary ?? (options.url ? undefined : await fileBytes(url));
  if (wasmBinary) return new Core(await createModule({ wasmBinary }));
  return new Core(await createModule({ locateFile: () => options.url ?? url.href }));
}
