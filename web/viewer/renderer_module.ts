import * as layouts from "../../build/wasm/web/layouts.js";
import { visibilityWords } from "../core/core.ts";
import type { CoreModule } from "../core/module.ts";
import { textAt } from "../core/text.ts";
import { RendererCamera } from "./renderer_camera.ts";
import { RendererError } from "./renderer_error.ts";
import { RendererInstance } from "./renderer_instance.ts";
import { RendererPicture } from "./renderer_picture.ts";
import { instantiateRenderer } from "./renderer_program.ts";
import { RendererVolume } from "./renderer_volume.ts";
import type { Splats } from "./types.ts";

/** FrameStatistics of shared/render/passes/frame_statistics.h, with the splats that were drawn. */
export interface DrawStatistics extends layouts.FrameStatistics, Splats {}

/** Whether this browser offers WebGL 2. */
export function hasWebGl2(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

/**
 * The C++ renderer (shared/render) on one canvas, through the C functions of shared/bindings/wasm/renderer_api.h.
 * Each canvas has its own WebAssembly instance.
 */
export class RendererModule {
  readonly picture: RendererPicture;
  readonly camera: RendererCamera;
  readonly #instance: RendererInstance;
  readonly #gl: WebGL2RenderingContext;
  #destroyed = false;

  private constructor(instance: RendererInstance, gl: WebGL2RenderingContext) {
    this.#instance = instance;
    this.#gl = gl;
    this.picture = new RendererPicture(instance);
    this.camera = new RendererCamera(instance);
  }

  /**
   * Loads the module and creates a WebGL 2 context on the canvas. Rejects with a RendererError if this
   * fails.
   */
  static async create(canvas: HTMLCanvasElement): Promise<RendererModule> {
    const instance = new RendererInstance(await instantiateRenderer());
    const { exports } = instance;
    // The C side finds its canvas by this name, and not by a selector in the document, because the
    // canvas may be in a shadow tree, or in no document.
    const name = "!canvas";
    exports.specialHTMLTargets[name] = canvas;
    const selector = instance.text(name);
    try {
      instance.check(exports._isosplat_renderer_create(selector));
    } catch (error) {
      if (hasWebGl2() || !(error instanceof RendererError)) throw error;
      throw new RendererError(error.message, "no-webgl2");
    } finally {
      exports._free(selector);
    }
    const gl = canvas.getContext("webgl2");
    if (!gl) throw new RendererError("the canvas has no WebGL 2 context");
    return new RendererModule(instance, gl);
  }

  /** The functions of the core, which use the same instance. */
  get exports(): CoreModule {
    return this.#instance.exports;
  }

  /** The volume with this number, which the caller chooses; it need not be set yet. */
  volume(number: number): RendererVolume {
    return new RendererVolume(this.#instance, this.#gl, number);
  }

  destroy(): void {
    if (this.#destroyed) return;
    this.#destroyed = true;
    this.#instance.exports._isosplat_renderer_destroy();
  }

  /** Whether the driver has compiled the shaders, so that `warmUp` does not wait. */
  isCompiled(): boolean {
    return this.#instance.exports._isosplat_renderer_is_compiled() !== 0;
  }

  /** Does in advance the work that the driver would otherwise do during the first picture. */
  warmUp(): void {
    this.#instance.check(this.#instance.exports._isosplat_renderer_warm_up());
  }

  /** Throws if the GPU has failed since the last call. Waits for the GPU: call it when that is idle. */
  checkGpu(): void {
    this.#instance.check(this.#instance.exports._isosplat_renderer_check_gpu());
  }

  /**
   * The surface, cap or slice at a position of an image of this size, from its upper left corner.
   */
  pick(x: number, y: number, width: number, height: number): layouts.Pick | undefined {
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_pick(x, y, width, height, this.#instance.scratch),
    );
    const pick = layouts.readPick(this.#instance.view(), this.#instance.scratch);
    return pick.found === 0 ? undefined : pick;
  }

  needsRedraw(width: number, height: number): boolean {
    return this.#instance.exports._isosplat_renderer_needs_redraw(width, height) !== 0;
  }

  draw(width: number, height: number): DrawStatistics {
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_draw(width, height, this.#instance.scratch),
    );
    return this.#readStatistics();
  }

  /** Whether refine() would smooth the edges of the last picture, drawn with this size. */
  canRefine(width: number, height: number): boolean {
    return this.#instance.exports._isosplat_renderer_can_refine(width, height) !== 0;
  }

  /**
   * Starts to compile the shaders for refine(). Returns whether refine() would not wait for them.
   */
  prepareRefine(): boolean {
    return this.#instance.exports._isosplat_renderer_prepare_refine() !== 0;
  }

  /** Draws the picture again, shifted by a fraction of a pixel, and shows the mean of all of them. */
  refine(width: number, height: number): DrawStatistics {
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_refine(width, height, this.#instance.scratch),
    );
    return this.#readStatistics();
  }

  /** Shows the picture that draw() and refine() lead to, and draws only its missing parts. */
  drawStill(width: number, height: number): DrawStatistics {
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_draw_still(width, height, this.#instance.scratch),
    );
    return this.#readStatistics();
  }

  /** Begins a picture of this size in tiles. Nothing else may change or be drawn until endTiles(). */
  beginTiles(width: number, height: number): void {
    this.#instance.check(this.#instance.exports._isosplat_renderer_begin_tiles(width, height));
  }

  /**
   * A part of the picture as RGBA, alpha not premultiplied, rows from the top: the mean of `pictures`, 1 … 8.
   */
  drawTile(
    x: number,
    y: number,
    width: number,
    height: number,
    pictures: number,
  ): Uint8ClampedArray<ArrayBuffer> {
    const bytes = 4 * width * height;
    const pointer = this.#instance.reserve(bytes);
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_draw_tile(x, y, width, height, pictures, pointer),
    );
    return new Uint8ClampedArray(
      this.#instance.exports.HEAPU8.slice(pointer, pointer + bytes).buffer,
    );
  }

  endTiles(): void {
    this.#instance.exports._isosplat_renderer_end_tiles();
  }

  /**
   * Starts an occlusion query: which regions of these chunks of a volume cover at least `minPixels`
   * pixels of the last picture, which must be up to date. 0: which regions may be visible at all.
   */
  beginOcclusionQuery(volume: number, handles: Uint32Array, minPixels: number): void {
    const pointer = this.#instance.reserve(handles.byteLength);
    this.#instance.exports.HEAPU32.set(handles, pointer >> 2);
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_begin_occlusion_query(
        volume,
        pointer,
        handles.length,
        minPixels,
      ),
    );
  }

  /** The answer, `visibilityWords` for each chunk that was drawn; undefined until it is ready. */
  takeOcclusionQuery(): Uint32Array | undefined {
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_take_occlusion_query(this.#instance.scratch),
    );
    const { isReady, count } = layouts.readOcclusionAnswer(
      this.#instance.view(),
      this.#instance.scratch,
    );
    if (isReady === 0) return undefined;
    const at = this.#instance.exports._isosplat_renderer_occlusion_answer() >> 2;
    return this.#instance.exports.HEAPU32.slice(at, at + visibilityWords * count);
  }

  /** Keeps the last picture, so that the next one can fade in over it. */
  holdPicture(): void {
    this.#instance.check(this.#instance.exports._isosplat_renderer_hold_picture());
  }

  /**
   * Call right after draw(). Shows the kept picture again, and starts a fade. False: no picture is
   * kept.
   */
  beginFade(): boolean {
    this.#instance.check(
      this.#instance.exports._isosplat_renderer_begin_fade(this.#instance.scratch),
    );
    return this.#instance.view().getUint32(this.#instance.scratch, true) !== 0;
  }

  /** Mixes the kept picture (0) with the last one (1). At 1 the last one becomes the kept one. */
  fade(progress: number): void {
    this.#instance.check(this.#instance.exports._isosplat_renderer_fade(progress));
  }

  /** GL_RENDERER. */
  rendererName(): string {
    return textAt(this.#instance.exports, this.#instance.exports._isosplat_renderer_name());
  }

  contextLost(): void {
    this.#instance.exports._isosplat_renderer_context_lost();
  }

  contextRestored(): void {
    this.#instance.check(this.#instance.exports._isosplat_renderer_context_restored());
  }

  #readStatistics(): DrawStatistics {
    const statistics = layouts.readFrameStatistics(this.#instance.view(), this.#instance.scratch);
    return { ...statistics, ...this.picture.splats };
  }
}
