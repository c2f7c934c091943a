import type { StoreInfo } from "../core/types.ts";
import type { Progress, StreamError } from "../stream/types.ts";
import type { RendererError } from "../viewer/renderer_error.ts";
import type { Camera, Clip, Slices } from "../viewer/types.ts";
import type { PickedSurface } from "./element_pick.ts";

/** The events of `<isosplat-viewer>`, by name. They are CustomEvents, and do not bubble. */
export interface IsosplatViewerEvents {
  opened: CustomEvent<StoreInfo>;
  progress: CustomEvent<Progress>;
  complete: CustomEvent<Progress>;
  camerachange: CustomEvent<Camera>;
  isovaluechange: CustomEvent<readonly number[]>;
  clipchange: CustomEvent<Clip>;
  sliceschange: CustomEvent<Slices>;
  stepchange: CustomEvent<number>;
  pick: CustomEvent<PickedSurface>;
  fault: CustomEvent<StreamError | RendererError>;
}

/** The events of `<isosplat-layer>`, by name. They are CustomEvents, and do not bubble. */
export interface IsosplatLayerEvents {
  opened: CustomEvent<StoreInfo>;
  isovaluechange: CustomEvent<readonly number[]>;
  fault: CustomEvent<StreamError | RendererError>;
}
