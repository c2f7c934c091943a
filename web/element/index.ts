/** Defines <isosplat-viewer>. */
export type { Progress, Source, StoreInfo, StreamError } from "../stream/index.ts";
export type { Camera, Clip, Look, RendererError, Surface } from "../viewer/index.ts";
export { IsosplatViewerElement, type IsosplatViewerEvents } from "./isosplat_viewer.ts";
