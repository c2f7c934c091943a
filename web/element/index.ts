/** Defines <isosplat-viewer> and <isosplat-layer>. */
export { setAssetBase } from "../core/assets.ts";
export type { StoreInfo } from "../core/types.ts";
export type { SavedSurface, SaveSurfaceOptions } from "../mesh/save_surface.ts";
export type { SceneSource } from "../scene/scene_source.ts";
export type { Source } from "../stream/source.ts";
export type { Progress, StreamError } from "../stream/types.ts";
export type { Layer } from "../viewer/layer.ts";
export type { RendererError } from "../viewer/renderer_error.ts";
export type { Time } from "../viewer/time.ts";
export type { Transform } from "../viewer/transform.ts";
export type {
  Camera,
  Clip,
  FieldLook,
  Label,
  Look,
  LookChange,
  Slices,
  Surface,
} from "../viewer/types.ts";
export type { IsosplatLayerEvents, IsosplatViewerEvents } from "./element_events.ts";
export type { PickedSurface } from "./element_pick.ts";
export { IsosplatLayerElement } from "./isosplat_layer.ts";
export { IsosplatViewerElement } from "./isosplat_viewer.ts";
