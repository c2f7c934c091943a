import type { Progress, StoreInfo, StreamError } from "../stream/index.ts";
import type { Camera, Clip, RendererError, Slices } from "../viewer/index.ts";

/** The events of the element, by name. They are CustomEvents, and do not bubble. */
export interface IsosplatViewerEvents {
  opened: CustomEvent<StoreInfo>;
  progress: CustomEvent<Progress>;
  complete: CustomEvent<Progress>;
  camerachange: CustomEvent<Camera>;
  isovaluechange: CustomEvent<readonly number[]>;
  clipchange: CustomEvent<Clip>;
  sliceschange: CustomEvent<Slices>;
  fault: CustomEvent<StreamError | RendererError>;
}
