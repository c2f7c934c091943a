import * as layouts from "../../build/wasm/web/layouts.js";
import { AssetError, compiledOnce } from "../core/compile_asset.ts";
import {
  type CoreModule,
  instantiate,
  type ModuleFactory,
  regionWords,
  textAt,
  visibilityWords,
  volumeRecord,
} from "../core/index.ts";
import { type FaultKind, faultOfStatus } from "../stream/faults.ts";
import type { ChunkPlace, StoreInfo } from "../stream/types.ts";
import type {
  Camera,
  Clip,
  ColourMap,
  Look,
  Projection,
  SlicePlane,
  Splats,
  Surface,
} from "./types.ts";
import { colourings, colourMaps, shadings, splatKinds } from "./types.ts";

/** The instance that Emscripten's factory creates: the functions of shared/bindings/wasm/renderer_api.h. */
interface Exports extends CoreModule {
  HEAPU8: Uint8Array;
  HEAPU32: Uint32Array;
  /** Emscripten's names of elements, which come before selectors. */
  specialHTMLTargets: Record<string, EventTarget>;
  _malloc(bytes: number): number;
  _free(pointer: number): void;
  _isosplat_renderer_create(selector: number): number;
  _isosplat_renderer_destroy(): void;
  _isosplat_renderer_is_compiled(): number;
  _isosplat_renderer_warm_up(): number;
  _isosplat_renderer_error(): number;
  _isosplat_renderer_set_volume(volume: number): number;
  _isosplat_renderer_reserve_chunk(
    handle: number,
    block: number,
    clusters: number,
    clusterBytes: number,
    offset: number,
  ): number;
  _isosplat_renderer_check_gpu(): number;
  _isosplat_renderer_remove_chunk(handle: number): void;
  _isosplat_renderer_set_visible(chunks: number, count: number): void;
  _isosplat_renderer_set_isosurfaces(isosurfaces: number, count: number): void;
  _isosplat_renderer_set_splats(kind: number, shading: number): void;
  _isosplat_renderer_set_appearance(appearance: number): void;
  _isosplat_renderer_set_light(light: number): void;
  _isosplat_renderer_set_clipping(box: number, planes: number, count: number): void;
  _isosplat_renderer_set_slices(planes: number, count: number, low: number, high: number): void;
  _isosplat_renderer_set_camera(camera: number): void;
  _isosplat_renderer_default_camera(camera: number, aspect: number): void;
  _isosplat_renderer_orbit(camera: number, right: number, up: number): void;
  _isosplat_renderer_pan(camera: number, right: number, down: number, height: number): void;
  _isosplat_renderer_zoom(camera: number, factor: number): void;
  _isosplat_renderer_bound(camera: number): void;
  _isosplat_renderer_colour_map(map: number): number;
  _isosplat_renderer_projection(
    camera: number,
    width: number,
    height: number,
    projection: number,
  ): void;
  _isosplat_renderer_pick(
    x: number,
    y: number,
    width: number,
    height: number,
    pick: number,
  ): number;
  _isosplat_renderer_needs_redraw(width: number, height: number): number;
  _isosplat_renderer_draw(width: number, height: number, statistics: number): number;
  _isosplat_renderer_prepare_refine(): number;
  _isosplat_renderer_can_refine(width: number, height: number): number;
  _isosplat_renderer_refine(width: number, height: number, statistics: number): number;
  _isosplat_renderer_draw_still(width: number, height: number, statistics: number): number;
  _isosplat_renderer_begin_tiles(width: number, height: number): number;
  _isosplat_renderer_draw_tile(
    x: number,
    y: number,
    width: number,
    height: number,
    rgba: number,
  ): number;
  _isosplat_renderer_end_tiles(): void;
  _isosplat_renderer_hold_picture(): number;
  _isosplat_renderer_begin_fade(hasBegun: number): number;
  _isosplat_renderer_fade(progress: number): number;
  _isosplat_renderer_begin_occlusion_query(
    handles: number,
    count: number,
    minPixels: number,
  ): number;
  _isosplat_renderer_take_occlusion_query(answer: number): number;
  _isosplat_renderer_occlusion_answer(): number;
  _isosplat_renderer_name(): number;
  _isosplat_renderer_context_lost(): void;
  _isosplat_renderer_context_restored(): number;
}

/** The renderer failed. `message` comes from the C++ renderer. */
export class RendererError extends Error {
  override readonly name = "RendererError";
  readonly kind: FaultKind;
  constructor(message: string, kind: FaultKind = "renderer-failed", cause?: unknown) {
    super(message, cause === undefined ? undefined : { cause });
    this.kind = kind;
  }
}

/** FrameStatistics of shared/render/passes/frame_statistics.h, with the splats that were drawn. */
export interface DrawStatistics extends layouts.FrameStatistics, Splats {}

function flagOf(projection: Projection | undefined): number {
  return projection === "orthographic" ? 1 : 0;
}

const noCamera = {
  target: [0, 0, 0],
  distance: 1,
  azimuth: 0,
  elevation: 0,
  roll: 0,
  fieldOfView: 30,
} satisfies Camera;

/** The channels of #rrggbb, 0 … 1. */
export function colourChannels(colour: string): [number, number, number] {
  const value = Number.parseInt(colour.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** Whether this browser offers WebGL 2. */
export function hasWebGl2(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

/**
 * The compiled code of the module. Fetches and compiles it once; an early call saves time later. Rejects
 * with an AssetError; after a failure the next call tries again.
 */
export const compiledRenderer = compiledOnce<WebAssembly.Module>(
  "isosplat-renderer.wasm",
  () => new URL("../../build/wasm/web/isosplat-renderer.wasm", import.meta.url),
);

const { maxClipPlanes, maxIsosurfaces } = layouts;

/** The largest group of records that one call takes or returns. Bulk data have their own memory. */
const scratchBytes = Math.max(
  layouts.volumeBytes,
  layouts.appearanceBytes,
  layouts.lightBytes,
  layouts.frameStatisticsBytes,
  layouts.cameraBytes + layouts.projectionBytes,
  layouts.pickBytes,
  layouts.isosurfaceBytes * maxIsosurfaces,
  layouts.clipBoxBytes + layouts.planeBytes * maxClipPlanes,
  layouts.planeBytes * layouts.maxSlices,
);
const drawnChunkWords = layouts.drawnChunkBytes / 4;

/**
 * The C++ renderer (shared/render) on one canvas, through the C functions of shared/bindings/wasm/renderer_api.h.
 * Each canvas has its own WebAssembly instance.
 */
export class RendererModule {
  readonly #exports: Exports;
  /** Memory for records: `scratchBytes`. */
  readonly #scratch: number;
  /** As setSplats() has set them; at first those of RenderSettings. */
  #splats: Splats = { kind: "ellipse", shading: "smooth" };
  /** Memory for bulk data. It grows as needed. */
  #bulk = 0;
  #bulkBytes = 0;
  #destroyed = false;
  /** The renderer's context. Samples are uploaded from JavaScript, without a copy in the heap. */
  #gl: WebGL2RenderingContext | null = null;

  private constructor(exports: Exports) {
    this.#exports = exports;
    this.#scratch = exports._malloc(scratchBytes);
  }

  /**
   * Loads the module and creates a WebGL 2 context on the canvas. Rejects with a RendererError if this
   * fails.
   */
  static async create(canvas: HTMLCanvasElement): Promise<RendererModule> {
    const [{ default: factory }, wasm] = await Promise.all([
      import("../../build/wasm/web/isosplat-renderer.js").catch((cause: unknown) => {
        const text = `the renderer's program cannot be fetched: ${String(cause)}`;
        throw new RendererError(text, "unreachable", cause);
      }),
      compiledRenderer().catch((cause: unknown) => {
        if (!(cause instanceof AssetError)) throw cause;
        throw new RendererError(cause.message, cause.kind, cause);
      }),
    ]);
    const exports = await instantiate<Exports>(factory as ModuleFactory, wasm);
    const renderer = new RendererModule(exports);
    // The C side finds its canvas by name, here, and not by a selector in the document: the canvas
    // may be in a shadow tree, or in none.
    const name = "!canvas";
    exports.specialHTMLTargets[name] = canvas;
    const selector = renderer.#text(name);
    try {
      renderer.#check(exports._isosplat_renderer_create(selector));
      renderer.#gl = canvas.getContext("webgl2");
    } catch (error) {
      if (hasWebGl2() || !(error instanceof RendererError)) throw error;
      throw new RendererError(error.message, "no-webgl2");
    } finally {
      exports._free(selector);
    }
    return renderer;
  }

  /** The functions of the core, which use the same instance. */
  get exports(): CoreModule {
    return this.#exports;
  }

  destroy(): void {
    if (this.#destroyed) return;
    this.#destroyed = true;
    this.#exports._isosplat_renderer_destroy();
  }

  /** Whether the driver has compiled the shaders, so that `warmUp` does not wait. */
  isCompiled(): boolean {
    return this.#exports._isosplat_renderer_is_compiled() !== 0;
  }

  /** Does the work that the driver would otherwise do during the first picture. */
  warmUp(): void {
    this.#check(this.#exports._isosplat_renderer_warm_up());
  }

  setVolume(info: StoreInfo): void {
    layouts.writeVolume(this.#view(), this.#scratch, volumeRecord(info));
    this.#check(this.#exports._isosplat_renderer_set_volume(this.#scratch));
  }

  /** samples, clusters: those of a DecodedChunk. */
  addChunk(handle: number, place: ChunkPlace, samples: Uint32Array, clusters: Uint8Array): void {
    const pointer = this.#reserve(clusters.byteLength);
    this.#exports.HEAPU8.set(clusters, pointer);
    layouts.writeBlock(this.#view(), this.#scratch, place);
    const offsetAt = this.#scratch + layouts.blockBytes;
    this.#check(
      this.#exports._isosplat_renderer_reserve_chunk(
        handle,
        this.#scratch,
        pointer,
        clusters.byteLength,
        offsetAt,
      ),
    );
    if (samples.length === 0) return;
    const offset = this.#view().getFloat64(offsetAt, true);
    this.#gl?.bufferSubData(WebGL2RenderingContext.ARRAY_BUFFER, offset, samples);
  }

  /** Throws if the GPU has failed since the last call. Waits for the GPU: call it when that is idle. */
  checkGpu(): void {
    this.#check(this.#exports._isosplat_renderer_check_gpu());
  }

  removeChunk(handle: number): void {
    this.#exports._isosplat_renderer_remove_chunk(handle);
  }

  /** Draws exactly these chunks from now on. regions: `regionWords` per chunk (RegionMask). */
  setVisible(handles: ArrayLike<number>, regions: ArrayLike<number>): void {
    const count = handles.length;
    const pointer = this.#reserve(count * layouts.drawnChunkBytes);
    const heap = this.#exports.HEAPU32;
    for (let i = 0; i < count; ++i) {
      const at = (pointer >> 2) + i * drawnChunkWords;
      heap[at + layouts.drawnChunkOffsets.handle / 4] = handles[i] ?? 0;
      const regionsAt = at + layouts.drawnChunkOffsets.regions / 4;
      for (let word = 0; word < regionWords; ++word) {
        heap[regionsAt + word] = regions[i * regionWords + word] ?? 0;
      }
    }
    this.#exports._isosplat_renderer_set_visible(pointer, count);
  }

  setSurfaces(surfaces: readonly Surface[]): void {
    const used = surfaces.slice(0, maxIsosurfaces);
    const data = this.#view();
    used.forEach(({ isovalue, colour, opacity }, i) => {
      const record = { isovalue, colour: colourChannels(colour), opacity };
      layouts.writeIsosurface(data, this.#scratch + i * layouts.isosurfaceBytes, record);
    });
    this.#exports._isosplat_renderer_set_isosurfaces(this.#scratch, used.length);
  }

  setSplats(splats: Splats): void {
    this.#splats = splats;
    const { kind, shading } = splats;
    const exports = this.#exports;
    exports._isosplat_renderer_set_splats(splatKinds.indexOf(kind), shadings.indexOf(shading));
  }

  /** range: of the quantity that the colour map shows. opacity: of the background. */
  setLook(look: Look, [colourLow, colourHigh]: readonly [number, number], opacity = 1): void {
    layouts.writeAppearance(this.#view(), this.#scratch, {
      colourLow,
      colourHigh,
      colourBy: colourings.indexOf(look.colourBy),
      colourMap: colourMaps.indexOf(look.colourMap),
      background: [...colourChannels(look.background), opacity],
      eyeDome: look.eyeDome,
    });
    this.#exports._isosplat_renderer_set_appearance(this.#scratch);
    layouts.writeLight(this.#view(), this.#scratch, look.light);
    this.#exports._isosplat_renderer_set_light(this.#scratch);
  }

  /** `count` evenly spaced colours of a colour map, from low to high, as CSS colours. */
  colours(map: ColourMap, count: number): string[] {
    const at = this.#exports._isosplat_renderer_colour_map(colourMaps.indexOf(map));
    return Array.from({ length: count }, (_, i) => {
      const last = layouts.colourMapColours - 1;
      const colour = at + 3 * Math.round((last * i) / (count - 1));
      return `rgb(${this.#exports.HEAPU8.subarray(colour, colour + 3).join(" ")})`;
    });
  }

  setClip({ low, high, planes, caps }: Clip): void {
    const used = planes.slice(0, maxClipPlanes);
    const data = this.#view();
    const planesAt = this.#scratch + layouts.clipBoxBytes;
    layouts.writeClipBox(data, this.#scratch, { low, high, caps: caps ? 1 : 0 });
    used.forEach((plane, i) => {
      layouts.writePlane(data, planesAt + i * layouts.planeBytes, plane);
    });
    this.#exports._isosplat_renderer_set_clipping(this.#scratch, planesAt, used.length);
  }

  /** `range`: the values that are black and white, unless slices have the colours of isovalues. */
  setSlices(planes: readonly SlicePlane[], [low, high]: readonly [number, number]): void {
    const used = planes.slice(0, layouts.maxSlices);
    const data = this.#view();
    used.forEach((plane, i) => {
      layouts.writePlane(data, this.#scratch + i * layouts.planeBytes, plane);
    });
    this.#exports._isosplat_renderer_set_slices(this.#scratch, used.length, low, high);
  }

  setCamera(camera: Camera): void {
    this.#writeCamera(camera);
    this.#exports._isosplat_renderer_set_camera(this.#scratch);
  }

  /** The camera of the first picture. `aspect`: width / height of the image. */
  defaultCamera(aspect: number, projection?: Projection): Camera {
    const data = this.#view();
    layouts.writeCamera(data, this.#scratch, { ...noCamera, orthographic: flagOf(projection) });
    this.#exports._isosplat_renderer_default_camera(this.#scratch, aspect);
    return this.#readCamera();
  }

  orbited(camera: Camera, rightDegrees: number, upDegrees: number): Camera {
    this.#writeCamera(camera);
    this.#exports._isosplat_renderer_orbit(this.#scratch, rightDegrees, upDegrees);
    return this.#readCamera();
  }

  panned(camera: Camera, rightPx: number, downPx: number, imageHeightPx: number): Camera {
    this.#writeCamera(camera);
    this.#exports._isosplat_renderer_pan(this.#scratch, rightPx, downPx, imageHeightPx);
    return this.#readCamera();
  }

  zoomed(camera: Camera, factor: number): Camera {
    this.#writeCamera(camera);
    this.#exports._isosplat_renderer_zoom(this.#scratch, factor);
    return this.#readCamera();
  }

  /** A valid camera: the same one, or the nearest one if its numbers are out of range. */
  bounded(camera: Camera): Camera {
    this.#writeCamera(camera);
    this.#exports._isosplat_renderer_bound(this.#scratch);
    return this.#readCamera();
  }

  /** World to clip space: a matrix of 4 × 4, column by column. */
  viewProjection(camera: Camera, width: number, height: number): Float64Array {
    this.#writeCamera(camera);
    const at = this.#scratch + layouts.cameraBytes;
    this.#exports._isosplat_renderer_projection(this.#scratch, width, height, at);
    return Float64Array.from(layouts.readProjection(this.#view(), at).clipFromWorld);
  }

  /** The surface, cap or slice at a place of an image of this size, from its upper left corner. */
  pick(x: number, y: number, width: number, height: number): layouts.Pick | undefined {
    this.#check(this.#exports._isosplat_renderer_pick(x, y, width, height, this.#scratch));
    const pick = layouts.readPick(this.#view(), this.#scratch);
    return pick.found === 0 ? undefined : pick;
  }

  needsRedraw(width: number, height: number): boolean {
    return this.#exports._isosplat_renderer_needs_redraw(width, height) !== 0;
  }

  draw(width: number, height: number): DrawStatistics {
    this.#check(this.#exports._isosplat_renderer_draw(width, height, this.#scratch));
    return this.#readStatistics();
  }

  /** Whether refine() would smooth the edges of the picture that was drawn last, with this size. */
  canRefine(width: number, height: number): boolean {
    return this.#exports._isosplat_renderer_can_refine(width, height) !== 0;
  }

  /** Starts to compile what refine() needs. Returns whether refine() would not wait for that. */
  prepareRefine(): boolean {
    return this.#exports._isosplat_renderer_prepare_refine() !== 0;
  }

  /** Draws the picture again, shifted by a fraction of a pixel, and shows the mean of all of them. */
  refine(width: number, height: number): DrawStatistics {
    this.#check(this.#exports._isosplat_renderer_refine(width, height, this.#scratch));
    return this.#readStatistics();
  }

  /** Shows the picture that draw() and refine() lead to, and draws only what is missing of it. */
  drawStill(width: number, height: number): DrawStatistics {
    this.#check(this.#exports._isosplat_renderer_draw_still(width, height, this.#scratch));
    return this.#readStatistics();
  }

  /** Begins a picture of this size in tiles. Nothing else may change or be drawn until endTiles(). */
  beginTiles(width: number, height: number): void {
    this.#check(this.#exports._isosplat_renderer_begin_tiles(width, height));
  }

  /** A part of the picture as RGBA, alpha not premultiplied, rows from the top. */
  drawTile(x: number, y: number, width: number, height: number): Uint8ClampedArray<ArrayBuffer> {
    const bytes = 4 * width * height;
    const pointer = this.#reserve(bytes);
    this.#check(this.#exports._isosplat_renderer_draw_tile(x, y, width, height, pointer));
    return new Uint8ClampedArray(this.#exports.HEAPU8.slice(pointer, pointer + bytes).buffer);
  }

  endTiles(): void {
    this.#exports._isosplat_renderer_end_tiles();
  }

  /**
   * Starts an occlusion query: which regions of these chunks show in at least `minPixels` pixels of
   * the picture that was drawn last, which must be up to date. 0: which may be visible at all.
   */
  beginOcclusionQuery(handles: Uint32Array, minPixels: number): void {
    const pointer = this.#reserve(handles.byteLength);
    this.#exports.HEAPU32.set(handles, pointer >> 2);
    this.#check(
      this.#exports._isosplat_renderer_begin_occlusion_query(pointer, handles.length, minPixels),
    );
  }

  /** The answer, `visibilityWords` for each chunk that was drawn; undefined until it is ready. */
  takeOcclusionQuery(): Uint32Array | undefined {
    this.#check(this.#exports._isosplat_renderer_take_occlusion_query(this.#scratch));
    const { isReady, count } = layouts.readOcclusionAnswer(this.#view(), this.#scratch);
    if (isReady === 0) return undefined;
    const at = this.#exports._isosplat_renderer_occlusion_answer() >> 2;
    return this.#exports.HEAPU32.slice(at, at + visibilityWords * count);
  }

  /** Keeps the picture that was drawn last, so that the next one can fade in over it. */
  holdPicture(): void {
    this.#check(this.#exports._isosplat_renderer_hold_picture());
  }

  /** Call it right after draw(). Shows the kept picture again, and starts a fade. False: none is kept. */
  beginFade(): boolean {
    this.#check(this.#exports._isosplat_renderer_begin_fade(this.#scratch));
    return this.#view().getUint32(this.#scratch, true) !== 0;
  }

  /** Mixes the kept picture (0) with the one drawn last (1). At 1 the latter becomes the kept one. */
  fade(progress: number): void {
    this.#check(this.#exports._isosplat_renderer_fade(progress));
  }

  /** GL_RENDERER. */
  rendererName(): string {
    return textAt(this.#exports, this.#exports._isosplat_renderer_name());
  }

  contextLost(): void {
    this.#exports._isosplat_renderer_context_lost();
  }

  contextRestored(): void {
    this.#check(this.#exports._isosplat_renderer_context_restored());
  }

  #check(status: number): void {
    if (status === 0) return;
    const message = textAt(this.#exports, this.#exports._isosplat_renderer_error());
    const name = textAt(this.#exports, this.#exports._isosplat_core_status_name(status));
    const isFull = faultOfStatus(name) === "out-of-memory";
    throw new RendererError(message, isFull ? "out-of-memory" : "renderer-failed");
  }

  /** A view of the heap, for the functions of layouts.js. Valid until the next call. */
  #view(): DataView {
    return new DataView(this.#exports.HEAPU8.buffer);
  }

  #writeCamera(camera: Camera): void {
    const orthographic = flagOf(camera.projection);
    layouts.writeCamera(this.#view(), this.#scratch, { ...camera, orthographic });
  }

  #readCamera(): Camera {
    const { orthographic, ...camera } = layouts.readCamera(this.#view(), this.#scratch);
    return orthographic ? { ...camera, projection: "orthographic" } : camera;
  }

  #readStatistics(): DrawStatistics {
    const statistics = layouts.readFrameStatistics(this.#view(), this.#scratch);
    return { ...statistics, ...this.#splats };
  }

  /** Memory of at least this size, 8-byte-aligned. It is valid until the next call of this method. */
  #reserve(bytes: number): number {
    if (bytes > this.#bulkBytes) {
      this.#exports._free(this.#bulk);
      this.#bulkBytes = Math.max(bytes, 1 << 16);
      this.#bulk = this.#exports._malloc(this.#bulkBytes);
      if (this.#bulk === 0) {
        this.#bulkBytes = 0;
        const text = `out of memory: ${bytes} bytes for a chunk's samples`;
        throw new RendererError(text, "out-of-memory");
      }
    }
    return this.#bulk;
  }

  #text(text: string): number {
    const bytes = new TextEncoder().encode(`${text}\0`);
    const pointer = this.#exports._malloc(bytes.length);
    this.#exports.HEAPU8.set(bytes, pointer);
    return pointer;
  }
}
