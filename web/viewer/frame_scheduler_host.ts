import type { RendererModule } from "./renderer_module.ts";
import type { Scene } from "./scene.ts";
import type { FrameReport, PictureSize } from "./types.ts";

/** A chunk whose samples, or values of a field, were uploaded, and the number of its volume in the renderer. */
export interface Upload {
  volume: number;
  id: number;
  of: "samples" | "field";
}

/** The functions that the scheduler needs from its viewer. */
export interface FrameSchedulerHost {
  /** Null while there is no volume or no renderer. */
  scene(): Scene | null;
  /** The number of visible layers whose first surface is still to arrive. */
  missingLayers(): number;
  /** Runs an action of the renderer; returns whether it succeeded. */
  guard(action: (renderer: RendererModule) => void): boolean;
  /** Checks that these uploads, and all before, have succeeded. */
  checkGpu(uploads: readonly Upload[]): void;
  /** The view that is drawn: world to clip space, column by column. `isMoving`: not at rest. */
  viewed(viewProjection: Float64Array, viewport: PictureSize, isMoving: boolean): void;
  isContextLost(): boolean;
  /** Sets the size of the canvas; returns whether it has changed. */
  fitCanvas(): boolean;
  drawn(report: FrameReport): void;
  /** `FrameScheduler.isBusy` may have changed. */
  busyChanged(): void;
}
