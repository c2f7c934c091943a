/**
 * The times at which frames of a view are drawn and tested. The test has its own clock, and needs
 * no GPU.
 */
import { beforeEach, expect, test, vi } from "vitest";
import { FrameScheduler, type FrameSchedulerHost } from "../../web/viewer/frame_scheduler.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";
import { identity } from "../../web/viewer/transform.ts";
import { defaultLook } from "../../web/viewer/types.ts";
import { fakeClock } from "./fake_clock.ts";

fakeClock();
beforeEach(() => void vi.stubGlobal("matchMedia", () => ({ matches: true })));

/** A GPU that has always finished all its work. */
const gl = {
  fenceSync: () => ({}),
  getSyncParameter: () => 1,
  SIGNALED: 1,
  UNSIGNALED: 0,
  deleteSync: () => {},
  flush: () => {},
  isContextLost: () => false,
};

/**
 * A view for which data are being fetched, and the times at which its occlusion queries began (ms).
 */
function streaming() {
  const tested: number[] = [];
  const drawnAt: number[] = [];
  let isDrawn = false;
  let missing = 0;
  const drawn = { kind: "quad", shading: "exact", programsLinked: 0 };
  const renderer = {
    picture: { setCamera: () => {}, setSplats: () => {} },
    camera: { viewProjection: () => new Float32Array(16) },
    needsRedraw: () => !isDrawn,
    canRefine: () => false,
    draw: () => {
      isDrawn = true;
      drawnAt.push(performance.now());
      return drawn;
    },
    checkGpu: () => {},
    beginOcclusionQuery: () => void tested.push(performance.now()),
    takeOcclusionQuery: () => new Uint32Array(),
  } as unknown as RendererModule;
  const session = {
    isClosed: false,
    needsRestingPicture: false,
    update: () => {},
    occlusionQuery: () => ({ ids: new Uint32Array([7]), minPixels: 255, view: 1, picture: 1 }),
    answerOcclusion: () => {},
  };
  const canvas = { width: 400, height: 300, getContext: () => gl };
  const scheduler = new FrameScheduler(canvas as unknown as HTMLCanvasElement, renderer, {
    scene: () => ({
      layers: [{ number: 0, session, isovalues: [60], transform: identity, isDone: false }],
      camera: { distance: 1 },
      kind: defaultLook.kind,
      shading: defaultLook.shading,
      pictureSize: null,
    }),
    missingLayers: () => missing,
    guard: (action: (renderer: RendererModule) => void) => {
      action(renderer);
      return true;
    },
    checkGpu: () => {},
    viewed: () => {},
    isContextLost: () => false,
    fitCanvas: () => false,
    drawn: () => {},
    busyChanged: () => {},
  } satisfies Record<keyof FrameSchedulerHost, unknown> as unknown as FrameSchedulerHost);
  const progress = { chunksToGo: 0, bytesToGo: 0, bytesFetched: 0, state: "refining" };
  scheduler.onProgress(progress as Parameters<FrameScheduler["onProgress"]>[0]);
  return {
    scheduler,
    tested,
    drawnAt,
    setMissing: (value: number) => {
      missing = value;
    },
    /** Chunks of a layer have arrived, which are not drawn. */
    arrive: () => {
      isDrawn = false;
      scheduler.onVisibleChange();
      return performance.now();
    },
    /** Moves the camera, which changes the picture. Returns the time. */
    move: () => {
      isDrawn = false;
      tested.length = 0;
      scheduler.onVisibleChange();
      scheduler.onCameraChange();
      return performance.now();
    },
  };
}

test("an occlusion query begins as soon as motion has ended, although more data are expected", () => {
  const { scheduler, tested, move } = streaming();
  vi.advanceTimersByTime(100);
  const moved = move();
  vi.advanceTimersByTime(200);
  expect(tested).toEqual([]);
  vi.advanceTimersByTime(100);
  expect(tested.length).toBeGreaterThan(0);
  expect((tested[0] ?? 0) - moved).toBeLessThan(270);
  scheduler.stop();
});

test("the first picture waits for the first surfaces of all layers, and is then drawn at once", () => {
  const { scheduler, drawnAt, setMissing, arrive } = streaming();
  setMissing(1);
  scheduler.request();
  vi.advanceTimersByTime(50);
  arrive();
  vi.advanceTimersByTime(100);
  expect(drawnAt).toEqual([]);
  expect(scheduler.isBusy).toBe(true);
  setMissing(0);
  const whole = arrive();
  vi.advanceTimersByTime(50);
  expect(drawnAt.length).toBe(1);
  expect((drawnAt[0] ?? 0) - whole).toBeLessThan(40);
  // A layer that is added later does not hold up the picture.
  setMissing(1);
  const later = arrive();
  vi.advanceTimersByTime(50);
  expect((drawnAt[1] ?? 0) - later).toBeLessThan(40);
  scheduler.stop();
});

test("the first picture waits for a missing layer for 0.3 s", () => {
  const { scheduler, drawnAt, setMissing, arrive } = streaming();
  setMissing(1);
  const begun = performance.now();
  vi.advanceTimersByTime(50);
  arrive();
  vi.advanceTimersByTime(400);
  expect(drawnAt[0]).toBeGreaterThanOrEqual(begun + 300);
  expect(drawnAt[0]).toBeLessThan(begun + 340);
  scheduler.stop();
});
