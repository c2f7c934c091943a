import type { StreamSession } from "../stream/session.ts";
import type { Camera, Look, PictureSize } from "./types.ts";

/** The data of a frame to draw. */
export interface Scene {
  session: StreamSession;
  camera: Camera;
  isovalues: number[];
  kind: Look["kind"];
  shading: Look["shading"];
  /**
   * If not null, streams for a picture of this size instead of the canvas. The canvas shows its
   * whole view.
   */
  pictureSize: PictureSize | null;
}
