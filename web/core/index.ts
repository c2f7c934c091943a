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
import { compileAsset, compiledOnce } from "./compile_asset.ts";
import { Core } from "./core.ts";
import type { CompiledModule } from "./instantiate.ts";
import { instantiateCore } from "./instantiate_core.ts";
import type { CoreModule } from "./module.ts";

export { setAssetBase } from "./assets.ts";
export { type ChunkShape, CoreError } from "./calls.ts";
export { AssetError } from "./compile_asset.ts";
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
  /** The address of isosplat-core.wasm. Default: beside its module, or in the folder of setAssetBase. */
  url?: string;
  /** An existing instance with the functions of the core, such as one of isosplat-renderer. */
  module?: CoreModule;
  /** The compiled code of isosplat-renderer, to create another instance of it. */
  renderer?: CompiledModule;
}

/** The compiled code of isosplat-core. Fetches and compiles it once. Rejects with an AssetError. */
export const compiledCore: () => Promise<CompiledModule> = compiledOnce(
  "isosplat-core.wasm",
  () => new URL("../../build/wasm/web/isosplat-core.wasm", import.meta.url),
);

/** Makes an instance of the core, in a browser, a worker, or Node (20.16 or newer). */
export async function loadCore(options: CoreOptions = {}): Promise<Core> {
  const { module, renderer } = options;
  if (module) return new Core(module);
  if (renderer) return instantiateCore({ renderer });
  return instantiateCore({ core: await compiled(options) });
}

function compiled({ wasmBinary, url }: CoreOptions): Promise<CompiledModule> {
  if (wasmBinary) return WebAssembly.compile(wasmBinary as BufferSource);
  if (url === undefined) return compiledCore();
  return compileAsset(new URL(url, typeof location === "undefined" ? undefined : location.href));
}
