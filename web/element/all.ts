/**
 * The exports of `import … from "isosplat"`: the element, and exports that most programs also need.
 */

export { CoreError } from "../core/calls.ts";
export { AssetError } from "../core/compile_asset.ts";
export { type Core, maxHeaderBytes, type Store } from "../core/core.ts";
export { loadCore } from "../core/load_core.ts";
export type { Chunk } from "../core/records.ts";
export type { Points } from "../core/types.ts";
export { forecastSurface, saveSurface } from "../mesh/save_surface.ts";
export { SurfaceReader } from "../mesh/surface_reader.ts";
export { openScene } from "../scene/open_scene.ts";
export { sceneAt, sceneOfFiles, servedScene } from "../scene/scene_source.ts";
export { BlobSource } from "../stream/blob_source.ts";
export { faults } from "../stream/faults.ts";
export { FileSource } from "../stream/file_source.ts";
export { ServerSource } from "../stream/server_source.ts";
export { StreamSession } from "../stream/session.ts";
export { SiteSource } from "../stream/site_source.ts";
export { StreamError } from "../stream/types.ts";
export { RendererError } from "../viewer/renderer_error.ts";
export { Viewer } from "../viewer/viewer.ts";
export * from "./index.ts";
