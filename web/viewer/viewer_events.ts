import type { StoreInfo } from "../core/types.ts";
import type { Decoder } from "../stream/decoder.ts";
import type { Progress, StreamError } from "../stream/types.ts";
import type { Layer, LayerOptions, LayerProperty } from "./layer.ts";
import type { Light } from "./light.ts";
import type { RendererError } from "./renderer_error.ts";
import type { Time } from "./time.ts";
import type { Camera, FrameReport, Projection, Surface } from "./types.ts";

export interface ViewerEvents {
  /** The first layer is open. Its first surface follows. */
  opened: StoreInfo;
  /** The streaming progress of the picture, the sum over all visible layers, has changed. */
  progress: Progress;
  /** A frame was drawn. */
  frame: FrameReport;
  /** `isBusy` has changed. */
  busy: boolean;
  /** The camera moved, by a gesture or by a call. */
  camera: Camera;
  /** A gesture turned the key light. */
  light: Light;
  /** The store at the source's URL was replaced. The new one is open now. */
  replaced: StoreInfo;
  /**
   * Emitted once for each occurrence of a fault (web/stream/faults.ts). Progress.fault is set as
   * long as a streaming fault lasts. The picture stays. If `info` is null afterwards, no volume is
   * open: call open() again.
   */
  error: StreamError | RendererError;
  /** The WebGL context was lost or restored. */
  context: "lost" | "restored";
  /** A layer is among `Viewer.layers`. */
  layeradd: Layer;
  /** A layer is no longer among `Viewer.layers`: it was removed or replaced. */
  layerremove: Layer;
  /** A layer has another index among `Viewer.layers`. */
  layermove: { layer: Layer; index: number };
  /** `Viewer.time` is another one. */
  time: Time | null;
  layerchange: { layer: Layer; property: LayerProperty };
  /** Like `error`, for a fault of a layer other than the first. The other layers continue. */
  layererror: { layer: Layer; error: StreamError | RendererError };
}

export interface ViewerOptions {
  /**
   * The largest number of samples (16 bytes each) in the GPU's memory, of all layers. Default: depends on the device's
   * memory (web/stream/device.ts).
   */
  sampleBudget?: number;
  /** Most bytes fetched for other isovalues while a view is complete: see StreamOptions. */
  backgroundBytes?: number;
  /** Stores up to this size are read as a whole while a view is complete: see StreamOptions. Default: 16 MB of all layers. */
  readAheadBytes?: number;
  /** Cells larger than this on the screen, in pixels, are refined. Default 1. */
  targetCellPixels?: number;
  /** The largest number of device pixels per CSS pixel. Default 2. */
  maxPixelRatio?: number;
  /** Whether mouse, touch and keys on the canvas move the camera. Default true. */
  controls?: boolean;
  /** The action of the key R. Default: `Viewer.reset()`. */
  reset?: () => void;
  /** Decodes chunks. Several viewers may share it; it is not closed with the viewer. Default: the viewer's own. */
  decoder?: Decoder;
}

export interface OpenOptions {
  /** The isosurfaces of the first view. Default: one, at the volume's first suggestion. */
  surfaces?: readonly Surface[];
  camera?: Camera;
  /** The projection of the first camera, if there is no `camera`. Default: the present one; at first, perspective. */
  projection?: Projection;
  signal?: AbortSignal;
}

export interface AddLayerOptions extends LayerOptions {
  /** Ends the opening. */
  signal?: AbortSignal;
}
