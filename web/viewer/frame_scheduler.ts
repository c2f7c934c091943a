import { measured } from "../stream/timeline.ts";
import type { Progress } from "../stream/types.ts";
import { Arrivals } from "./arrivals.ts";
import { cameraOfPicture } from "./camera_views.ts";
import { Fade } from "./fade.ts";
import { FinalPicture } from "./final_picture.ts";
import { FrameLoop } from "./frame_loop.ts";
import type { FrameSchedulerHost, Upload } from "./frame_scheduler_host.ts";
import { GpuPulse, GpuTimer } from "./gpu_timer.ts";
import { OcclusionTester } from "./occlusion_tester.ts";
import { PictureSplats } from "./picture_splats.ts";
import { RendererError } from "./renderer_error.ts";
import type { DrawStatistics, RendererModule } from "./renderer_module.ts";
import { RestClock } from "./rest_clock.ts";
import { isStreaming, type Scene } from "./scene.ts";
import { viewProjectionOf } from "./transform.ts";
import type { Splats } from "./types.ts";

/**
 * A still view gets smooth edges, ambient occlusion and shadows if its picture at rest took no longer
 * than this (ms). Such a picture takes about 1.5 times as long.
 */
const longestSmoothed = 1000;
/** Edges are smoothed by a mean of such pictures if one of them takes no longer (ms). */
const longestContinued = 600;
/** Interval between checks whether the GPU has finished a picture, or the driver a shader (ms). */
const shortestWait = 8;
/** New chunks fade in if a picture takes no longer than this (ms). */
const longestFaded = 50;

/**
 * Decides when a canvas is drawn, and in which quality: fast splats while something moves; the exact
 * surface and smooth edges at rest; new chunks as they arrive, as far as the GPU is fast enough.
 */
export class FrameScheduler {
  readonly #canvas: HTMLCanvasElement;
  readonly #owner: FrameSchedulerHost;
  readonly #renderer: RendererModule;
  readonly #loop = new FrameLoop((now) => this.#frame(now));
  readonly #splats = new PictureSplats();
  readonly #timer: GpuTimer;
  readonly #fade: Fade;
  readonly #pulse: GpuPulse;
  readonly #visibility: OcclusionTester;
  readonly #arrivals: Arrivals;
  readonly #rest = new RestClock();
  readonly #final = new FinalPicture();
  #restTimer = 0;
  #drawTimer = 0;
  /** When the timer ends. */
  #drawAt = 0;
  #shaderTimer = 0;
  /** Whether the last frame was at rest: nothing has moved or arrived since. */
  #isResting = false;
  /** The view has changed since the last picture was drawn. */
  #isChanged = false;
  /** Whether another frame follows the last one at once. */
  #isFollowed = false;
  /** Whether the present picture has ambient occlusion and shadows, if these are on. */
  #isOccluded = false;
  /** Chunks that were uploaded, but not yet checked for exhausted GPU memory. */
  #unchecked: Upload[] = [];

  /** canvas: the canvas on which the view is drawn. */
  constructor(canvas: HTMLCanvasElement, renderer: RendererModule, owner: FrameSchedulerHost) {
    const gl = canvas.getContext("webgl2");
    if (!gl) throw new RendererError("the canvas has no WebGL 2 context");
    this.#canvas = canvas;
    this.#owner = owner;
    this.#renderer = renderer;
    this.#arrivals = new Arrivals(() => owner.missingLayers());
    this.#timer = new GpuTimer(gl);
    const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");
    this.#fade = new Fade(renderer, () => !reducedMotion.matches);
    this.#pulse = new GpuPulse(gl);
    this.#visibility = new OcclusionTester({
      guard: (action) => owner.guard(action),
      isIdle: () =>
        !this.#rest.isMoving(performance.now()) && !this.#timer.isBusy && this.#pulse.beats(),
      movesUntil: () => this.#rest.movesUntil,
      isContextLost: () => owner.isContextLost(),
      answered: (settled) => {
        if (!settled) this.#rest.fastPictureTested(performance.now());
      },
      ended: () => this.request(),
    });
  }

  /** Whether something is visible, or it is known that there is nothing to see. */
  get isBegun(): boolean {
    return this.#arrivals.isBegun;
  }

  /** Whether the picture will still change without further calls. */
  get isBusy(): boolean {
    return (
      this.#rest.isStreaming ||
      !this.#isResting ||
      this.#isFollowed ||
      this.#loop.isRequested ||
      this.#visibility.isRunning ||
      this.#timer.isBusy ||
      this.#shaderTimer !== 0 ||
      this.#drawTimer !== 0 ||
      this.#fade.isRunning
    );
  }

  /** Requests a frame. */
  request(): void {
    this.#loop.request();
    this.#owner.busyChanged();
  }

  /** The camera, the surfaces or their look has changed. */
  onCameraChange(): void {
    this.#rest.moved(performance.now());
    this.#isChanged = true;
    this.#isResting = false;
    this.#final.changed();
    this.request();
  }

  /** The samples of a chunk have been uploaded. */
  onUpload(upload: Upload): void {
    this.#unchecked.push(upload);
  }

  /** The set of chunks to draw has changed. */
  onVisibleChange(): void {
    const now = performance.now();
    this.#arrivals.begin(now);
    this.#rest.arrived(now);
    this.#isResting = false;
    this.#final.changed();
    // The chunks of many layers arrive one after the other. A frame that does not draw them would take time.
    if (this.#rest.isMoving(now) || this.#mayDraw(now)) this.request();
    else this.#owner.busyChanged();
  }

  /** The progress of streaming has changed. */
  onProgress(progress: Progress): void {
    const now = performance.now();
    const isLast = this.#arrivals.progressed(now, progress);
    const isEmpty = !this.isBegun && progress.state !== "opening";
    const wasStreaming = this.#rest.isStreaming;
    this.#rest.isStreaming = isStreaming(progress);
    this.#final.streams(this.#rest.isStreaming);
    const hasEnded = wasStreaming && !this.#rest.isStreaming;
    if (isEmpty) this.#arrivals.begin(now);
    // The first picture may have waited for a layer that turns out to have no surface.
    const mayBegin = this.#arrivals.lacksPicture && this.#mayDraw(now);
    if (isLast || isEmpty || hasEnded || mayBegin) this.request();
    else this.#owner.busyChanged();
  }

  /** The context is lost: pending queries and fences will not be answered. */
  onContextLost(): void {
    this.#timer.stop();
    this.#pulse.contextLost();
    this.#visibility.stop();
    this.#unchecked = [];
    this.cancelFade();
  }

  /** The next picture is unrelated to the present one. */
  cancelFade(): void {
    this.#fade.forget();
  }

  /** Another volume is being opened. */
  onVolumeChange(): void {
    this.#arrivals.forget();
    this.#rest.isStreaming = false;
    this.#unchecked = [];
    this.#visibility.stop();
    this.cancelFade();
  }

  stop(): void {
    this.#loop.stop();
    clearTimeout(this.#restTimer);
    clearTimeout(this.#drawTimer);
    this.#drawTimer = 0;
    clearTimeout(this.#shaderTimer);
    this.#visibility.stop();
    this.#timer.stop();
  }

  /**
   * Draws in the quality of a view at rest. smooth: also smooth edges, which takes several draws
   * unless they are smooth already.
   */
  drawToSave(smooth: boolean): void {
    const { width, height } = this.#canvas;
    const scene = this.#owner.scene();
    const renderer = this.#renderer;
    if (scene) {
      const needsRedraw = renderer.needsRedraw(width, height);
      renderer.picture.setSplats(this.#splats.next(scene, true, needsRedraw));
    }
    this.cancelFade();
    const isFinal = !renderer.needsRedraw(width, height) && !renderer.canRefine(width, height);
    if (smooth || isFinal) renderer.drawStill(width, height);
    else renderer.draw(width, height);
  }

  /**
   * Whether a picture of a still view may be drawn now, as far as arrivals and the GPU are concerned: it is
   * drawn again when the last picture is finished.
   */
  #mayDraw(now: number): boolean {
    const { milliseconds } = this.#splats;
    return this.#isOver(
      now,
      this.#timer.isBusy ? shortestWait : this.#arrivals.wait(now, milliseconds),
    );
  }

  /** Whether a wait (ms) is over. If not, a frame follows at its end, or earlier. */
  #isOver(now: number, wait: number): boolean {
    if (wait <= 0) return true;
    const at = now + wait;
    if (this.#drawTimer !== 0 && this.#drawAt <= at) return false;
    clearTimeout(this.#drawTimer);
    this.#drawAt = at;
    this.#drawTimer = window.setTimeout(() => {
      this.#drawTimer = 0;
      this.request();
    }, wait);
    return false;
  }

  /** Whether the last picture lacks smooth edges and shadows. */
  get canRefine(): boolean {
    return this.#renderer.canRefine(this.#canvas.width, this.#canvas.height);
  }

  /** Draws a frame. Returns whether another frame must follow at once. */
  #frame(now: number): boolean {
    const scene = this.#owner.scene();
    this.#isFollowed = false;
    if (!scene) return false;
    const { layers, camera, pictureSize } = scene;
    const renderer = this.#renderer;
    const isResized = this.#owner.fitCanvas();
    const { width, height } = this.#canvas;
    const isMoving = this.#rest.isMoving(now);
    // Nothing more arrives until this picture has been tested.
    const needsRest = layers.some(({ session }) => session.needsRestingPicture);
    const mayRest = layers.every(({ session, isDone }) => isDone || session.needsRestingPicture);
    if (!isMoving && needsRest && mayRest) this.#rest.restNow();
    const { restsAt } = this.#rest;
    const isTesting = this.#visibility.isRunning;
    // A picture that is being tested keeps its splats: with others it would have to be drawn again.
    const isResting = isTesting ? this.#isResting : now >= restsAt;
    this.#isResting = isResting;

    const viewport = pictureSize ?? { width, height };
    renderer.picture.setCamera(
      pictureSize ? cameraOfPicture(camera, pictureSize, width / height) : camera,
    );
    const splats = this.#splats.next(scene, isResting, renderer.needsRedraw(width, height));
    renderer.picture.setSplats(splats);
    const viewProjection = renderer.camera.viewProjection(camera, viewport.width, viewport.height);
    this.#owner.viewed(viewProjection, viewport, isMoving);
    for (const { session, isovalues, transform, stepCellPixels } of layers) {
      session.update({
        viewProjection: viewProjectionOf(viewProjection, transform),
        viewport,
        isovalues,
        moving: isMoving,
        ...(stepCellPixels === undefined ? {} : { stepCellPixels }),
      });
    }
    const wasFading = this.#fade.isRunning;
    const isBegun = this.isBegun && this.#isOver(now, this.#arrivals.waitOfFirst(now));
    if (isBegun && renderer.needsRedraw(width, height)) {
      const isOther = isMoving || isResized || this.#isChanged;
      if (isOther || (!isTesting && this.#mayDraw(now))) {
        if (isOther) this.#fade.forget();
        this.#owner.guard(() => this.#fade.beforeDraw(now));
        this.#draw(scene, () => renderer.draw(width, height));
        this.#isOccluded = false;
        this.#isChanged = false;
        if (isOther || !this.#splats.isFast(longestFaded, splats)) this.#fade.forget();
        else this.#owner.guard(() => this.#fade.afterDraw(now, this.#arrivals.areExpected));
      }
    } else if (wasFading) {
      this.#owner.guard(() => this.#fade.step(now, this.#arrivals.areExpected));
    } else if (
      isResting &&
      !isTesting &&
      !pictureSize &&
      !this.#rest.isStreaming &&
      this.#maySmooth(splats) &&
      renderer.canRefine(width, height)
    ) {
      if (renderer.prepareRefine()) this.#refine(scene, now, splats);
      else this.#awaitShaders();
    }
    if (!isMoving && !renderer.needsRedraw(width, height)) {
      this.#visibility.test(
        layers,
        isResting || splats.kind === this.#splats.ofOther(scene, true).kind,
      );
    }
    // Draw one more frame when the motion has ended, which tests what is visible, and one at rest,
    // which draws finer splats and lets streaming refine.
    clearTimeout(this.#restTimer);
    if (!isResting && !isTesting) {
      const wait = Math.max(0, (isMoving ? this.#rest.movesUntil : restsAt) - now) + 1;
      this.#restTimer = window.setTimeout(() => this.request(), wait);
    }
    // Smoothing begins in the frame after the end of a fade.
    this.#isFollowed = wasFading || this.#fade.isRunning;
    this.#owner.busyChanged();
    return this.#isFollowed;
  }

  /**
   * Draws the picture again, shifted by a fraction of a pixel. The first time also adds ambient
   * occlusion and shadows, which fade in.
   */
  #refine(scene: Scene, now: number, splats: Splats): void {
    const { width, height } = this.#canvas;
    const renderer = this.#renderer;
    if (this.#isOccluded || !this.#splats.isFast(longestFaded, splats)) {
      this.#draw(scene, () => renderer.refine(width, height));
    } else {
      // Its duration is not that of one picture, and is not measured.
      this.#owner.guard(() =>
        this.#fade.toOccluded(
          now,
          () => renderer.draw(width, height),
          () => renderer.refine(width, height),
        ),
      );
    }
    this.#isOccluded = true;
  }

  /** Compiling may take a second; the page stays responsive meanwhile. */
  #awaitShaders(): void {
    clearTimeout(this.#shaderTimer);
    this.#shaderTimer = window.setTimeout(() => {
      this.#shaderTimer = 0;
      this.request();
    }, shortestWait);
  }

  /** Only one picture is in flight, so that a gesture does not have to wait for more. */
  #maySmooth(splats: Splats): boolean {
    const longest = this.#isOccluded ? longestContinued : longestSmoothed;
    return !this.#timer.isBusy && this.#splats.isFast(longest, splats);
  }

  #draw(scene: Scene, draw: () => DrawStatistics): void {
    let report: DrawStatistics | undefined;
    this.#owner.guard(() => {
      const startedAt = performance.now();
      const drawn = measured("isosplat:drawing", draw);
      report = drawn;
      this.#arrivals.pictureDrawn();
      this.#splats.drawn(scene, drawn);
      const view = this.#isResting ? this.#final.view : undefined;
      this.#timer.measure(startedAt, (milliseconds) => {
        this.#splats.measured(scene, drawn, milliseconds);
        this.#arrivals.drawn(performance.now(), milliseconds);
        this.#final.finished(view);
        this.#settled();
      });
    });
    if (report) this.#owner.drawn({ ...report, framesPerSecond: this.#loop.framesPerSecond });
  }

  /** The GPU has finished a picture. If the view is at rest, the actions that waited for this continue. */
  #settled(): void {
    if (performance.now() < this.#rest.restsAt) {
      this.#owner.busyChanged();
      return;
    }
    // The GPU is idle now. During a run of frames this check would have to wait for them.
    const unchecked = this.#unchecked;
    this.#unchecked = [];
    if (unchecked.length > 0) this.#owner.checkGpu(unchecked);
    this.request();
  }
}
