import type { StreamSession } from "../stream/session.ts";
import type { Progress } from "../stream/types.ts";
import type { Transform } from "./transform.ts";
import type { Camera, Look, PictureSize } from "./types.ts";

/** A layer that is drawn. */
export interface SceneLayer {
  /** The number of its volume in the renderer. */
  number: number;
  session: StreamSession;
  isovalues: number[];
  transform: Transform;
  /** CameraView.stepCellPixels. */
  stepCellPixels?: number;
  /** It waits for nothing: neither data nor a query. */
  isDone: boolean;
}

/** The data of a frame to draw. */
export interface Scene {
  layers: readonly SceneLayer[];
  camera: Camera;
  kind: Look["kind"];
  shading: Look["shading"];
  /**
   * If not null, streams for a picture of this size instead of the canvas. The canvas shows its
   * whole view.
   */
  pictureSize: PictureSize | null;
}

/** Whether more will come for the present view. */
export function isStreaming({ state }: Progress): boolean {
  return !["complete", "limited", "incomplete", "offline"].includes(state);
}
