/**
 * Builds stores in the browser: the same bytes, and so the same content id, as the program `isosplat
 * build`. Nothing here is loaded until a volume is to be built.
 *
 *     const { store, report } = await buildStore(
 *       { voxels: [256, 256, 128], type: "u8", name: "engine", format: "NRRD" },
 *       file, // a Blob or Uint8Array with the voxels
 *       { progress: ({ fraction }) => …, signal },
 *     );
 */
export { BlobParts } from "../core/blob_parts.ts";
export { type BuildStoreOptions, type BuiltStore, buildStore, buildWith } from "./build_store.ts";
export { Builder } from "./builder.ts";
export { directBuild, type Encoder } from "./direct.ts";
export { type Port, PortEncoder, serveEncoder } from "./encoder_port.ts";
export { type BuilderHost, compileBuilder, instantiateBuilder } from "./module.ts";
export { StoreParts } from "./store_parts.ts";
export type * from "./types.ts";
export type { Voxels } from "./voxels.ts";
