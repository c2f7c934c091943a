/** Defines <isosplat-viewer>. */
export { setAssetBase } from "../core/index.ts";
export type { SavedSurface, SaveSurfaceOptions } from "../mesh/index.ts";
export type { Progress, Source, StoreInfo, StreamError } from "../stream/index.ts";
export type { Camera, Clip, Look, RendererError, Slices, Surface } from "../viewer/index.ts";
export type { IsosplatViewerEvents } from "./element_events.ts";
export { IsosplatViewerElement } from "./isosplat_viewer.ts";
