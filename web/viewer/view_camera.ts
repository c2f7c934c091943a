import type { StoreInfo } from "../core/types.ts";
import type { CanvasSize } from "./canvas_size.ts";
import type { RendererModule } from "./renderer_module.ts";
import type { Camera, Projection } from "./types.ts";

/** The functions that the camera needs from its viewer. */
export interface ViewCameraHost {
  renderer(): RendererModule | null;
  /** The volume that is open. */
  info(): StoreInfo | null;
  moved(camera: Camera): void;
}

/** The camera of a viewer: its limits, its first view of the volumes, and its moves. */
export class ViewCamera {
  readonly #size: CanvasSize;
  readonly #host: ViewCameraHost;
  #camera: Camera | null = null;

  constructor(size: CanvasSize, host: ViewCameraHost) {
    this.#size = size;
    this.#host = host;
  }

  /** Null until a volume is open. */
  get camera(): Camera | null {
    return this.#camera;
  }

  /**
   * Called when a volume is open. `asked`, `projection`: of `OpenOptions`; `before`: the camera at
   * the beginning of opening.
   */
  opened(
    renderer: RendererModule,
    asked: Camera | undefined,
    projection: Projection | undefined,
    before: Camera | null,
  ): void {
    if (!asked) {
      this.#camera = this.#first(renderer, projection);
    } else if (this.#camera && this.#camera !== before) {
      // It was moved while the volume was reopened: listeners already know this camera.
      this.set(this.#camera);
    } else {
      this.#camera = renderer.camera.bounded(asked);
    }
  }

  /** The camera within the limits of the open volume. */
  set(camera: Camera): void {
    this.#camera = this.#openRenderer?.camera.bounded(camera) ?? camera;
    this.#host.moved(this.#camera);
  }

  /** The first view of all volumes; null until one is open. */
  get whole(): Camera | null {
    const renderer = this.#openRenderer;
    return renderer && this.#first(renderer);
  }

  viewProjection(width: number, height: number, camera = this.#camera): Float64Array | null {
    if (!camera) return null;
    const size = [Math.max(1, width), Math.max(1, height)] as const;
    return this.#openRenderer?.camera.viewProjection(camera, ...size) ?? null;
  }

  orbit(rightDegrees: number, upDegrees: number): void {
    const renderer = this.#host.renderer();
    if (renderer && this.#camera) {
      this.set(renderer.camera.orbited(this.#camera, rightDegrees, upDegrees));
    }
  }

  pan(rightPx: number, downPx: number): void {
    const renderer = this.#host.renderer();
    if (renderer && this.#camera) {
      this.set(renderer.camera.panned(this.#camera, rightPx, downPx, this.#size.cssHeight));
    }
  }

  /** The point at this offset from the picture's centre (CSS pixels) keeps its position. */
  zoom(factor: number, at: { x: number; y: number }): void {
    const renderer = this.#host.renderer();
    if (!renderer || !this.#camera) return;
    const before = this.#camera;
    const zoomed = renderer.camera.zoomed(before, factor);
    const keep = 1 - before.distance / zoomed.distance;
    this.set(renderer.camera.panned(zoomed, at.x * keep, at.y * keep, this.#size.cssHeight));
  }

  get #openRenderer(): RendererModule | null {
    return this.#host.info() && this.#host.renderer();
  }

  #first(renderer: RendererModule, projection = this.#camera?.projection): Camera {
    return renderer.camera.defaultCamera(this.#size.aspect, projection);
  }
}
