/**
 * The times at which frames of a view are drawn and tested. The test has its own clock, and needs
 * no GPU.
 */
import { beforeEach, expect, test, vi } from "vitest";
import type { Progress } from "../../web/stream/index.ts";
import { FrameScheduler } from "../../web/viewer/frame_scheduler.ts";
import type { FrameSchedulerHost } from "../../web/viewer/frame_scheduler_host.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";
import { identity } from "../../web/viewer/transform.ts";
import { defaultLook, type Splats } from "../../web/viewer/types.ts";
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
  let splats: Splats = { kind: "quad", shading: "exact" };
  const setSplats = (next: Splats): void => {
    isDrawn &&= next.kind === splats.kind && next.shading === splats.shading;
    splats = next;
  };
  const renderer = {
    picture: { setCamera: () => {}, setSplats },
    camera: { viewProjection: () => new Float32Array(16) },
    needsRedraw: () => !isDrawn,
    canRefine: () => false,
    draw: () => {
      isDrawn = true;
      drawnAt.push(performance.now());
      return { ...splats, programsLinked: 0 };
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
  const progress = (state: string): void =>
    scheduler.onProgress({ chunksToGo: 0, bytesToGo: 0, bytesFetched: 0, state } as Progress);
  progress("refining");
  return {
    scheduler,
    tested,
    drawnAt,
    progress,
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
  move();
  vi.advanceTimersByTime(100);
  const moved = move();
  vi.advanceTimersByTime(200);
  expect(tested).toEqual([]);
  vi.advanceTimersByTime(100);
  expect(tested.length).toBeGreaterThan(0);
  expect((tested[0] ?? 0) - moved).toBeLessThan(270);
  scheduler.stop();
});

test("a single change is drawn and tested at once", () => {
  const { scheduler, tested, drawnAt, move } = streaming();
  vi.advanceTimersByTime(100);
  const moved = move();
  vi.advanceTimersByTime(50);
  expect((drawnAt.at(-1) ?? 0) - moved).toBeLessThan(20);
  expect((tested[0] ?? Number.POSITIVE_INFINITY) - moved).toBeLessThan(50);
  scheduler.stop();
});

test("marks the finished picture at rest of a view for which nothing more will arrive, once", () => {
  const mark = vi.spyOn(performance, "mark");
  const finals = () => mark.mock.calls.filter(([name]) => name === "isosplat:final").length;
  const { scheduler, move, progress } = streaming();
  vi.advanceTimersByTime(3000);
  move();
  vi.advanceTimersByTime(3000);
  expect(finals(), "data are still being fetched").toBe(0);
  progress("complete");
  vi.advanceTimersByTime(3000);
  expect(finals()).toBe(1);
  move();
  progress("refining");
  vi.advanceTimersByTime(20);
  progress("complete");
  expect(finals(), "the picture is not finished").toBe(1);
  vi.advanceTimersByTime(3000);
  expect(finals()).toBe(2);
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
