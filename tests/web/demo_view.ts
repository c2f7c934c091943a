import type { CameraView } from "../../web/stream/index.ts";

/** A parallel view of all 256³ cells of a demo volume along y. A cell of level 0 has size/256 pixels. */
export function parallelView(isovalue: number, size = 64): CameraView {
  const scale = 2 / 256;
  return {
    viewProjection: [
      ...[scale, 0, 0, 0],
      ...[0, 0, scale, 0],
      ...[0, scale, 0, 0],
      ...[-1, -1, -1, 1],
    ],
    viewport: { width: size, height: size },
    isovalues: [isovalue],
    moving: false,
  };
}
