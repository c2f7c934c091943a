/** The client of the page, without a picture: the bytes that it fetches for a view of a volume. */
import type { Core } from "../../../web/core/index.ts";
import {
  type CameraView,
  InlineDecoder,
  type Progress,
  ServerSource,
  StreamSession,
} from "../../../web/stream/index.ts";

export interface Fetched {
  /** Payload until the first surface, and until the view is complete. */
  firstBytes: number;
  bytes: number;
  requests: number;
  finestLevel: number;
}

/**
 * A view of the whole volume from the front, at a distance of 1.5 times its longest axis, with a
 * field of view of 45°.
 */
function frontView(
  { voxels, spacing, origin }: StreamSession["info"],
  isovalue: number,
  [width, height]: readonly [number, number],
): CameraView {
  const extent = voxels.map((n, i) => (n - 1) * (spacing[i] ?? 1));
  const [cx = 0, cy = 0, cz = 0] = extent.map((length, i) => (origin[i] ?? 0) + length / 2);
  const longest = Math.max(...extent);
  const focal = 1 / Math.tan(Math.PI / 8);
  const [near, far] = [0.1 * longest, 10 * longest];
  const depth = (far + near) / (far - near);
  const shift = (2 * far * near) / (far - near);
  const eye = cy - 1.5 * longest;
  const across = (focal * height) / width;
  return {
    // Columns of projection · view: x to the right, z up, looking along +y.
    viewProjection: [
      ...[across, 0, 0, 0],
      ...[0, 0, depth, 1],
      ...[0, focal, 0, 0],
      ...[-across * cx, -focal * cz, -depth * eye - shift, -eye],
    ],
    viewport: { width, height },
    isovalues: [isovalue],
    moving: false,
  };
}

/** Opens a volume of a server, and shows an isovalue until the picture is complete. */
export async function visit(
  core: Core,
  base: string,
  volume: string,
  isovalue: number,
  pixels: readonly [number, number],
): Promise<Fetched> {
  performance.clearMarks("isosplat:surface");
  let complete: (progress: Progress) => void = () => {};
  let fail: (error: Error) => void = () => {};
  const done = new Promise<Progress>((resolve, reject) => {
    complete = resolve;
    fail = reject;
  });
  const session = await StreamSession.open(new ServerSource({ base, volume }), core, {
    decoder: new InlineDecoder(core),
    // Fetch only the bytes of this view.
    backgroundBytes: 0,
    readAheadBytes: 0,
    firstIsovalues: [isovalue],
    // This suffices for all volumes, so that the budget of a device does not limit the growth.
    sampleBudget: 2 ** 30,
    events: {
      samples: () => true,
      drop: () => {},
      visible: () => {},
      progress: (progress) => {
        if (progress.complete) complete(progress);
      },
      error: (error) => fail(error),
      replaced: (error) => fail(error),
    },
  });
  try {
    session.update(frontView(session.info, isovalue, pixels));
    const { bytesFetched, requests, finestLevel } = await done;
    const [mark] = performance.getEntriesByName("isosplat:surface", "mark");
    const detail = (mark as PerformanceMark | undefined)?.detail as { bytesReceived: number };
    if (!detail) throw new Error(`${volume}: expected a surface of ${isovalue}, found none`);
    return { firstBytes: detail.bytesReceived, bytes: bytesFetched, requests, finestLevel };
  } finally {
    session.close();
  }
}
