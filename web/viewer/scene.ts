import type { StreamSession } from "../stream/session.ts";
import type { Camera, Look, PictureSize } from "./types.ts";

/** What is to be drawn. */
export interface Scene {
  session: StreamSession;
  camera: Camera;
  isovalues: number[];
  kind: Look["kind"];
  shading: Look["shading"];
  /** Streams for a picture of this size instead of the canvas, which shows all of its view. */
  pictureSize: PictureSize | null;
}
