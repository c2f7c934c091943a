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
export { setAssetBase } from "./assets.ts";
export { type ChunkShape, CoreError } from "./calls.ts";
export { AssetError } from "./compile_asset.ts";
export * from "./core.ts";
export { type CompiledModule, instantiate, type ModuleFactory } from "./instantiate.ts";
export { type CoreOptions, compiledCore, loadCore } from "./load_core.ts";
export type { CoreModule } from "./module.ts";
export { type Chunk, type Page, volumeRecord } from "./records.ts";
export { textAt } from "./text.ts";
export type { DecodedChunk, Points, Samples, StoreInfo, StoreMetadata, Triple } from "./types.ts";
export { failureOf, type WorkerFailure } from "./worker_failure.ts";
