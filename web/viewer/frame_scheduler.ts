import { measured, type Progress, type StreamSession } from "../stream/index.ts";
import { Fade } from "./fade.ts";
import { FrameLoop } from "./frame_loop.ts";
import { GpuPulse, GpuTimer } from "./gpu_timer.ts";
import { OcclusionTester } from "./occlusion_tester.ts";
import { type DrawStatistics, RendererError, type RendererModule } from "./renderer_module.ts";
import { SplatChoice } from "./splat_choice.ts";
import type { Camera, FrameReport, Look, SplatKind } from "./types.ts";

/** The view rests when nothing has moved or arrived for so long (ms). */
const restAfter = 220;
/** A picture of a resting view that takes no longer (ms) is drawn a few times more, for smooth edges. */
const longestSmoothed = 400;
/** While a picture is being drawn, it is looked again after so long (ms). */
const shortestWait = 8;
/** Arrivals fade in where a picture takes no longer (ms). */
const longestFaded = 50;

/** What is to be drawn. */
export interface Scene {
  session: StreamSession;
  camera: Camera;
  isovalues: number[];
  kind: Look["kind"];
}

/** What a picture asks of its viewer. */
export interface FrameSchedulerHost {
  /** Null while there is nothing to draw, or nothing to draw with. */
  scene(): Scene | null;
  /** Does what may fail in the renderer; answers whether it did not. */
  guard(action: (renderer: RendererModule) => void): boolean;
  /** Asks the GPU whether all is there that was sent to it, these chunks among it. */
  checkGpu(ids: readonly number[]): void;
  isContextLost(): boolean;
  /** Gives the canvas its size; answers whether that is another one. */
  fitCanvas(): boolean;
  drawn(report: FrameReport): void;
  /** `FrameScheduler.isBusy` may have changed. */
  busyChanged(): void;
}

/**
 * When a canvas is drawn, and how finely: fast splats while something moves, the exact surface and
 * smooth edges at rest, what arrives as it comes, as far as the GPU keeps up.
 */
export class FrameScheduler {
  readonly #canvas: HTMLCanvasElement;
  readonly #owner: FrameSchedulerHost;
  readonly #renderer: RendererModule;
  readonly #loop = new FrameLoop((now) => this.#frame(now));
  readonly #choice = new SplatChoice();
  readonly #timer: GpuTimer;
  readonly #fade: Fade;
  readonly #pulse: GpuPulse;
  readonly #visibility: OcclusionTester;
  #lastMotion = Number.NEGATIVE_INFINITY;
  #lastArrival = Number.NEGATIVE_INFINITY;
  #restTimer = 0;
  #drawTimer = 0;
  #chunksToGo = 0;
  /** Of the present view, data are on their way, or are to be asked for. */
  #isStreaming = false;
  /** As of the last frame; nothing has moved or arrived since. */
  #isResting = false;
  /** The last frame is followed by another one at once. */
  #isFollowed = false;
  /** From when on what has arrived may be drawn, as long as more is to come. */
  #nextArrivals = 0;
  /** What the last picture that was measured took (ms), and of what. */
  #took: { kind: SplatKind; milliseconds: number } | null = null;
  /** Chunks that went to the GPU, which has not been asked since whether there was room for them. */
  #unchecked: number[] = [];
  /** Of this volume: until there is something to see, drawing would only take the GPU's time. */
  #isBegun = false;

  /** `canvas`: the one that the view draws on. */
  constructor(canvas: HTMLCanvasElement, renderer: RendererModule, owner: FrameSchedulerHost) {
    const gl = canvas.getContext("webgl2");
    if (!gl) throw new RendererError("the canvas has no WebGL 2 context");
    this.#canvas = canvas;
    this.#owner = owner;
    this.#renderer = renderer;
    this.#timer = new GpuTimer(gl);
    this.#fade = new Fade(renderer);
    this.#pulse = new GpuPulse(gl);
    this.#visibility = new OcclusionTester({
      guard: (action) => owner.guard(action),
      isIdle: () =>
        performance.now() - this.#lastMotion >= restAfter &&
        !this.#timer.isBusy &&
        this.#pulse.beats(),
      isContextLost: () => owner.isContextLost(),
      ended: () => this.request(),
    });
  }

  /** There is something to see, or it is known that there is nothing. */
  get isBegun(): boolean {
    return this.#isBegun;
  }

  /** The picture is still to change by itself. */
  get isBusy(): boolean {
    return (
      this.#isStreaming ||
      !this.#isResting ||
      this.#isFollowed ||
      this.#loop.isRequested ||
      this.#visibility.isRunning ||
      this.#timer.isBusy ||
      this.#fade.isRunning
    );
  }

  /** Asks for a frame. */
  request(): void {
    this.#loop.request();
    this.#owner.busyChanged();
  }

  /** The camera or what is shown has changed. */
  onCameraChange(): void {
    this.#lastMotion = performance.now();
    this.#isResting = false;
    this.request();
  }

  /** A chunk's samples went to the GPU. */
  onUpload(id: number): void {
    this.#unchecked.push(id);
  }

  /** Other chunks are drawn. */
  onVisibleChange(): void {
    this.#isBegun = true;
    this.#lastArrival = performance.now();
    this.#isResting = false;
    this.request();
  }

  /** Streaming went on. */
  onProgress({ chunksToGo, state }: Progress): void {
    const isLast = this.#chunksToGo > 0 && chunksToGo === 0;
    const isEmpty = !this.#isBegun && state !== "opening";
    this.#chunksToGo = chunksToGo;
    this.#isStreaming = !["complete", "limited", "incomplete", "offline"].includes(state);
    if (isEmpty) this.#isBegun = true;
    if (isLast || isEmpty) this.request();
    else this.#owner.busyChanged();
  }

  /** Nothing that was asked of the GPU is answered any more. */
  onContextLost(): void {
    this.#timer.stop();
    this.#pulse.contextLost();
    this.#visibility.stop();
    this.#unchecked = [];
    this.cancelFade();
  }

  /** What is drawn next has nothing to do with what is there. */
  cancelFade(): void {
    this.#fade.forget();
  }

  /** Another volume is opened. */
  onVolumeChange(): void {
    this.#isBegun = false;
    this.#chunksToGo = 0;
    this.#isStreaming = false;
    this.#unchecked = [];
    this.#visibility.stop();
    this.cancelFade();
  }

  stop(): void {
    this.#loop.stop();
    clearTimeout(this.#restTimer);
    clearTimeout(this.#drawTimer);
    this.#visibility.stop();
    this.#timer.stop();
  }

  /** Draws as finely as at rest. `smooth`: a few times more, for smooth edges. */
  drawToSave(smooth: boolean): void {
    const { width, height } = this.#canvas;
    const scene = this.#owner.scene();
    if (scene) this.#renderer.setKind(this.#kind(scene, true));
    this.cancelFade();
    this.#renderer.draw(width, height);
    while (smooth && this.#renderer.canRefine(width, height)) this.#renderer.refine(width, height);
  }

  #kind({ kind, camera }: Scene, isResting: boolean): SplatKind {
    return kind === "automatic" ? this.#choice.kind(isResting, camera.distance) : kind;
  }

  /**
   * A still view is drawn anew when the last picture is done; what has arrived waits as long as that
   * took, where more is to come: a slow GPU would else draw every few chunks anew, and take the
   * processor's time from those that follow.
   */
  #mayDraw(now: number): boolean {
    let wait = this.#chunksToGo > 0 ? this.#nextArrivals - now : 0;
    if (this.#timer.isBusy) wait = shortestWait;
    if (wait <= 0) return true;
    clearTimeout(this.#drawTimer);
    this.#drawTimer = window.setTimeout(() => this.request(), wait);
    return false;
  }

  /** Answers whether another frame is to follow at once. */
  #frame(now: number): boolean {
    const scene = this.#owner.scene();
    this.#isFollowed = false;
    if (!scene) return false;
    const { session, camera, isovalues } = scene;
    const renderer = this.#renderer;
    const isResized = this.#owner.fitCanvas();
    const { width, height } = this.#canvas;
    const quietSince = Math.max(this.#lastMotion, this.#lastArrival);
    const isMoving = now - this.#lastMotion < restAfter;
    const isResting = now - quietSince >= restAfter;
    this.#isResting = isResting;

    renderer.setCamera(camera);
    const kind = this.#kind(scene, isResting);
    renderer.setKind(kind);
    session.update({
      viewProjection: renderer.viewProjection(camera, width, height),
      viewport: { width, height },
      isovalues,
      moving: isMoving,
    });
    const isTesting = this.#visibility.isRunning;
    const wasFading = this.#fade.isRunning;
    if (this.#isBegun && renderer.needsRedraw(width, height)) {
      if (isMoving || isResized || (!isTesting && this.#mayDraw(now))) {
        if (isMoving || isResized) this.#fade.forget();
        this.#owner.guard(() => this.#fade.beforeDraw(now));
        this.#draw(scene, () => renderer.draw(width, height));
        if (isMoving || !this.#isFast(longestFaded, kind)) this.#fade.forget();
        else this.#owner.guard(() => this.#fade.afterDraw(now, this.#chunksToGo > 0));
      }
    } else if (wasFading) {
      this.#owner.guard(() => this.#fade.step(now, this.#chunksToGo > 0));
    } else if (
      isResting &&
      !isTesting &&
      this.#maySmooth(kind) &&
      renderer.canRefine(width, height)
    ) {
      this.#draw(scene, () => renderer.refine(width, height));
    }
    if (!isMoving && !renderer.needsRedraw(width, height)) {
      this.#visibility.test(session, isResting || kind === this.#kind(scene, true));
    }
    // Once more when it has come to rest: for the finer splats, and so that streaming refines.
    clearTimeout(this.#restTimer);
    if (!isResting) {
      const wait = Math.max(0, quietSince + restAfter - now) + 1;
      this.#restTimer = window.setTimeout(() => this.request(), wait);
    }
    // Smoothing begins in the frame after a fade's last.
    this.#isFollowed = wasFading || this.#fade.isRunning;
    this.#owner.busyChanged();
    return this.#isFollowed;
  }

  /** Whether the last picture of this kind took no longer (ms). */
  #isFast(longest: number, kind: SplatKind): boolean {
    return this.#took?.kind === kind && this.#took.milliseconds <= longest;
  }

  /** One picture at a time, so that a gesture need not wait for more than one. */
  #maySmooth(kind: SplatKind): boolean {
    return !this.#timer.isBusy && this.#isFast(longestSmoothed, kind);
  }

  #draw({ camera }: Scene, draw: () => DrawStatistics): void {
    let report: DrawStatistics | undefined;
    this.#owner.guard(() => {
      const startedAt = performance.now();
      const drawn = measured("isosplat:drawing", draw);
      report = drawn;
      this.#timer.measure(startedAt, (milliseconds) => {
        this.#choice.measured(drawn, milliseconds, camera.distance);
        this.#nextArrivals = performance.now() + milliseconds;
        this.#took = { kind: drawn.kind, milliseconds };
        this.#settled();
      });
    });
    if (report) this.#owner.drawn({ ...report, framesPerSecond: this.#loop.framesPerSecond });
  }

  /** A picture is done: where the view rests, what waited for the GPU goes on. */
  #settled(): void {
    const quietSince = Math.max(this.#lastMotion, this.#lastArrival);
    if (performance.now() - quietSince < restAfter) {
      this.#owner.busyChanged();
      return;
    }
    // Now the GPU has little else to do: asking it while frames follow each other would wait.
    const unchecked = this.#unchecked;
    this.#unchecked = [];
    if (unchecked.length > 0) this.#owner.checkGpu(unchecked);
    this.request();
  }
}
