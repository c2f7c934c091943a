/** Defines <isosplat-viewer>. */
export { setAssetBase } from "../core/assets.ts";
export type { StoreInfo } from "../core/types.ts";
export type { SavedSurface, SaveSurfaceOptions } from "../mesh/save_surface.ts";
export type { Source } from "../stream/source.ts";
export type { Progress, StreamError } from "../stream/types.ts";
export type { RendererError } from "../viewer/renderer_error.ts";
export type { Camera, Clip, Look, Slices, Surface } from "../viewer/types.ts";
export type { IsosplatViewerEvents } from "./element_events.ts";
export { IsosplatViewerElement } from "./isosplat_viewer.ts";
