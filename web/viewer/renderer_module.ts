import {
  type CoreModule,
  instantiate,
  type ModuleFactory,
  visibilityWords,
} from "../core/index.ts";
import { type FaultKind, faultOfStatus } from "../stream/faults.ts";
import type { ChunkPlace, StoreInfo } from "../stream/types.ts";
import { maxClipPlanes } from "./clipping.ts";
import type { Camera, Clip, ColourMap, Look, SplatKind, Surface } from "./types.ts";
import { colourings, colourMaps, maxSurfaces, splatKinds } from "./types.ts";

/** What Emscripten's factory yields: the exports of shared/wasm/renderer_api.h and the heap. */
interface Exports extends CoreModule {
  HEAPU8: Uint8Array;
  HEAPF64: Float64Array;
  HEAPU32: Uint32Array;
  _malloc(bytes: number): number;
  _free(pointer: number): void;
  _isosplat_renderer_create(selector: number): number;
  _isosplat_renderer_destroy(): void;
  _isosplat_renderer_is_compiled(): number;
  _isosplat_renderer_warm_up(): number;
  _isosplat_renderer_error(): number;
  _isosplat_renderer_set_volume(grid: number, mapping: number): number;
  _isosplat_renderer_add_chunk(
    id: number,
    level: number,
    x: number,
    y: number,
    z: number,
    samples: number,
    count: number,
  ): number;
  _isosplat_renderer_check_gpu(): number;
  _isosplat_renderer_remove_chunk(id: number): void;
  _isosplat_renderer_set_visible(ids: number, regions: number, count: number): void;
  _isosplat_renderer_set_isosurfaces(surfaces: number, count: number): void;
  _isosplat_renderer_set_kind(kind: number): void;
  _isosplat_renderer_set_colouring(by: number, map: number, low: number, high: number): void;
  _isosplat_renderer_set_background(red: number, green: number, blue: number, alpha: number): void;
  _isosplat_renderer_set_lighting(ambient: number, specular: number, eyeDome: number): void;
  _isosplat_renderer_set_clipping(box: number, planes: number, count: number): void;
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
    matrix: number,
  ): void;
  _isosplat_renderer_needs_redraw(width: number, height: number): number;
  _isosplat_renderer_draw(width: number, height: number, statistics: number): number;
  _isosplat_renderer_can_refine(width: number, height: number): number;
  _isosplat_renderer_refine(width: number, height: number, statistics: number): number;
  _isosplat_renderer_hold_picture(): number;
  _isosplat_renderer_begin_fade(): number;
  _isosplat_renderer_fade(progress: number): number;
  _isosplat_renderer_begin_occlusion_query(ids: number, count: number, minPixels: number): number;
  _isosplat_renderer_take_occlusion_query(): number;
  _isosplat_renderer_occlusion_answer(): number;
  _isosplat_renderer_limits(limits: number): number;
  _isosplat_renderer_context_lost(): void;
  _isosplat_renderer_context_restored(): number;
}

/** The renderer failed. `message` is the core's. */
export class RendererError extends Error {
  override readonly name = "RendererError";
  readonly kind: FaultKind;
  constructor(message: string, kind: FaultKind = "renderer-failed", cause?: unknown) {
    super(message, cause === undefined ? undefined : { cause });
    this.kind = kind;
  }
}

export interface DrawStatistics {
  samplesDrawn: number;
  samplesResident: number;
  gpuBytes: number;
  chunksDrawn: number;
  chunksCulled: number;
  drawCalls: number;
  kind: SplatKind;
  /** For the first time in this draw, which took longer for it. */
  programsLinked: number;
}

/** #rrggbb → 0 … 1. */
export function colourChannels(colour: string): [number, number, number] {
  const value = Number.parseInt(colour.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** Whether this browser offers what is drawn with. */
export function hasWebGl2(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

const wasmUrl = new URL("../../build/wasm/web/isosplat-renderer.wasm", import.meta.url).href;

let canvasNumber = 0;
let compiled: Promise<WebAssembly.Module> | null = null;

/** The module's code, fetched and compiled once. Call it early to have it sooner. */
export function compiledRenderer(): Promise<WebAssembly.Module> {
  compiled ??= compile();
  // A failure is not kept: the next call tries again.
  compiled.catch(() => {
    compiled = null;
  });
  return compiled;
}

async function compile(): Promise<WebAssembly.Module> {
  const response = await fetch(wasmUrl).catch((cause) => {
    throw new RendererError(`${wasmUrl}: the renderer cannot be fetched`, "unreachable", cause);
  });
  if (!response.ok) {
    const text = `expected the renderer at ${wasmUrl}, found status ${response.status}`;
    throw new RendererError(text, "server-fault");
  }
  // Static hosts that do not know .wasm send another type, which streaming refuses.
  const isTyped = response.headers.get("content-type")?.startsWith("application/wasm");
  if (isTyped) return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

/**
 * The C++ renderer (shared/render) on one canvas, through the C functions of shared/wasm/renderer_api.h.
 * One instance a canvas; each is a WebAssembly instance of its own.
 */
export class RendererModule {
  readonly #exports: Exports;
  /** Room for the arrays that the functions take: 64 doubles. */
  readonly #scratch: number;
  /** Room for bulk data, grown as needed. */
  #bulk = 0;
  #bulkBytes = 0;
  #destroyed = false;

  private constructor(exports: Exports) {
    this.#exports = exports;
    this.#scratch = exports._malloc(64 * 8);
  }

  /**
   * Loads the module and makes a WebGL 2 context on the canvas. Rejects with a RendererError when there
   * is none to be had.
   */
  static async create(canvas: HTMLCanvasElement): Promise<RendererModule> {
    const [{ default: factory }, wasm] = await Promise.all([
      import("../../build/wasm/web/isosplat-renderer.js").catch((cause: unknown) => {
        throw new RendererError("the renderer's program cannot be fetched", "unreachable", cause);
      }),
      compiledRenderer(),
    ]);
    const exports = await instantiate<Exports>(factory as ModuleFactory, wasm);
    const renderer = new RendererModule(exports);
    // The C side finds its canvas by selector.
    canvas.id ||= `isosplat-canvas-${++canvasNumber}`;
    const selector = renderer.#text(`#${CSS.escape(canvas.id)}`);
    try {
      renderer.#check(exports._isosplat_renderer_create(selector));
    } catch (error) {
      if (hasWebGl2() || !(error instanceof RendererError)) throw error;
      throw new RendererError(error.message, "no-webgl2");
    } finally {
      exports._free(selector);
    }
    return renderer;
  }

  /** For the parts of the core that share this instance. */
  get exports(): CoreModule {
    return this.#exports;
  }

  destroy(): void {
    if (this.#destroyed) return;
    this.#destroyed = true;
    this.#exports._isosplat_renderer_destroy();
  }

  /** Whether `warmUp` need not wait for the driver's compiler. */
  isCompiled(): boolean {
    return this.#exports._isosplat_renderer_is_compiled() !== 0;
  }

  /** What the driver puts off until the first picture, before there is one. */
  warmUp(): void {
    this.#check(this.#exports._isosplat_renderer_warm_up());
  }

  setVolume(info: StoreInfo): void {
    const { voxels, spacing, origin, direction, mapping } = info;
    this.#doubles([...voxels, ...spacing, ...origin, ...direction, mapping.offset, mapping.scale]);
    this.#check(this.#exports._isosplat_renderer_set_volume(this.#scratch, this.#scratch + 18 * 8));
  }

  /** samples: PackedSample, 4 words each. */
  addChunk(id: number, place: ChunkPlace, samples: Uint32Array): void {
    const [x, y, z] = place.block;
    const pointer = this.#reserve(samples.byteLength);
    this.#exports.HEAPU32.set(samples, pointer >> 2);
    this.#check(
      this.#exports._isosplat_renderer_add_chunk(
        id,
        place.level,
        x,
        y,
        z,
        pointer,
        samples.length / 4,
      ),
    );
  }

  /** Throws what the GPU could not do since the last call. Waits for it: call when it is done. */
  checkGpu(): void {
    this.#check(this.#exports._isosplat_renderer_check_gpu());
  }

  removeChunk(id: number): void {
    this.#exports._isosplat_renderer_remove_chunk(id);
  }

  /** ids: one a chunk; regions: `regionWords` a chunk, see StreamEvents.visible. */
  setVisible(ids: ArrayLike<number>, regions: ArrayLike<number>): void {
    const pointer = this.#reserve(4 * (ids.length + regions.length));
    this.#exports.HEAPU32.set(ids, pointer >> 2);
    this.#exports.HEAPU32.set(regions, (pointer >> 2) + ids.length);
    this.#exports._isosplat_renderer_set_visible(pointer, pointer + ids.length * 4, ids.length);
  }

  setSurfaces(surfaces: readonly Surface[]): void {
    const used = surfaces.slice(0, maxSurfaces);
    this.#doubles(used.flatMap((s) => [s.isovalue, ...colourChannels(s.colour), s.opacity]));
    this.#exports._isosplat_renderer_set_isosurfaces(this.#scratch, used.length);
  }

  setKind(kind: SplatKind): void {
    this.#exports._isosplat_renderer_set_kind(splatKinds.indexOf(kind));
  }

  /** range: of the quantity that the colour map shows. */
  setLook(look: Look, range: readonly [number, number]): void {
    this.#exports._isosplat_renderer_set_colouring(
      colourings.indexOf(look.colourBy),
      colourMaps.indexOf(look.colourMap),
      range[0],
      range[1],
    );
    this.#exports._isosplat_renderer_set_background(...colourChannels(look.background), 1);
    this.#exports._isosplat_renderer_set_lighting(0.25, 0.15, look.eyeDome);
  }

  /** A colour map from low to high: as many colours as asked for, evenly spaced, as CSS colours. */
  colours(map: ColourMap, count: number): string[] {
    const at = this.#exports._isosplat_renderer_colour_map(colourMaps.indexOf(map));
    return Array.from({ length: count }, (_, i) => {
      const colour = at + 3 * Math.round((255 * i) / (count - 1));
      return `rgb(${this.#exports.HEAPU8.subarray(colour, colour + 3).join(" ")})`;
    });
  }

  setClip({ low, high, planes }: Clip): void {
    const used = planes.slice(0, maxClipPlanes);
    const numbers = used.flatMap(({ normal, offset }) => [...normal, offset]);
    this.#doubles([...low, ...high, ...numbers]);
    this.#exports._isosplat_renderer_set_clipping(
      this.#scratch,
      this.#scratch + 6 * 8,
      used.length,
    );
  }

  setCamera(camera: Camera): void {
    this.#putCamera(camera);
    this.#exports._isosplat_renderer_set_camera(this.#scratch);
  }

  /** `aspect`: the image's width / height. */
  defaultCamera(aspect: number): Camera {
    this.#exports._isosplat_renderer_default_camera(this.#scratch, aspect);
    return this.#takeCamera();
  }

  orbited(camera: Camera, rightDegrees: number, upDegrees: number): Camera {
    this.#putCamera(camera);
    this.#exports._isosplat_renderer_orbit(this.#scratch, rightDegrees, upDegrees);
    return this.#takeCamera();
  }

  panned(camera: Camera, rightPx: number, downPx: number, imageHeightPx: number): Camera {
    this.#putCamera(camera);
    this.#exports._isosplat_renderer_pan(this.#scratch, rightPx, downPx, imageHeightPx);
    return this.#takeCamera();
  }

  zoomed(camera: Camera, factor: number): Camera {
    this.#putCamera(camera);
    this.#exports._isosplat_renderer_zoom(this.#scratch, factor);
    return this.#takeCamera();
  }

  /** A camera that can be drawn from, whatever numbers this one has. */
  bounded(camera: Camera): Camera {
    this.#putCamera(camera);
    this.#exports._isosplat_renderer_bound(this.#scratch);
    return this.#takeCamera();
  }

  /** World to clip space, column by column. The array is the caller's. */
  viewProjection(camera: Camera, width: number, height: number): Float64Array {
    this.#putCamera(camera);
    const matrix = this.#scratch + 8 * 8;
    this.#exports._isosplat_renderer_projection(this.#scratch, width, height, matrix);
    return this.#exports.HEAPF64.slice(matrix >> 3, (matrix >> 3) + 16);
  }

  needsRedraw(width: number, height: number): boolean {
    return this.#exports._isosplat_renderer_needs_redraw(width, height) !== 0;
  }

  draw(width: number, height: number): DrawStatistics {
    this.#check(this.#exports._isosplat_renderer_draw(width, height, this.#scratch));
    return this.#takeStatistics();
  }

  /** Whether refine() would smooth the edges of the picture last drawn, of this size. */
  canRefine(width: number, height: number): boolean {
    return this.#exports._isosplat_renderer_can_refine(width, height) !== 0;
  }

  /** Draws the still view once more, moved by a part of a pixel, and shows the mean. */
  refine(width: number, height: number): DrawStatistics {
    this.#check(this.#exports._isosplat_renderer_refine(width, height, this.#scratch));
    return this.#takeStatistics();
  }

  /**
   * Starts to find out which regions of these chunks show in so many pixels of the picture drawn
   * last, which must not need to be redrawn; with 0, of which any part may be seen.
   */
  beginOcclusionQuery(ids: Uint32Array, minPixels: number): void {
    const pointer = this.#reserve(ids.byteLength);
    this.#exports.HEAPU32.set(ids, pointer >> 2);
    this.#check(
      this.#exports._isosplat_renderer_begin_occlusion_query(pointer, ids.length, minPixels),
    );
  }

  /** The answer, `visibilityWords` for each chunk that was drawn; undefined while it is not there. */
  takeOcclusionQuery(): Uint32Array | undefined {
    const count = this.#exports._isosplat_renderer_take_occlusion_query();
    if (count < 0) return undefined;
    const at = this.#exports._isosplat_renderer_occlusion_answer() >> 2;
    return this.#exports.HEAPU32.slice(at, at + visibilityWords * count);
  }

  /** Keeps the picture just drawn, so that the next one can come in its place step by step. */
  holdPicture(): void {
    this.#check(this.#exports._isosplat_renderer_hold_picture());
  }

  /** Right after draw(): shows the held picture, for fade() to go on from. False: none is held. */
  beginFade(): boolean {
    const begun = this.#exports._isosplat_renderer_begin_fade();
    if (begun < 0) this.#check(begun);
    return begun === 1;
  }

  /** Shows the held picture (0) and the one drawn last (1) mixed; at 1 that is held. */
  fade(progress: number): void {
    this.#check(this.#exports._isosplat_renderer_fade(progress));
  }

  /** GL_RENDERER. */
  rendererName(): string {
    return this.#read(this.#exports._isosplat_renderer_limits(this.#scratch));
  }

  contextLost(): void {
    this.#exports._isosplat_renderer_context_lost();
  }

  contextRestored(): void {
    this.#check(this.#exports._isosplat_renderer_context_restored());
  }

  #check(status: number): void {
    if (status === 0) return;
    const message = this.#read(this.#exports._isosplat_renderer_error());
    const name = this.#read(this.#exports._isosplat_core_status_name(Math.abs(status)));
    const isFull = faultOfStatus(name) === "out-of-memory";
    throw new RendererError(message, isFull ? "out-of-memory" : "renderer-failed");
  }

  #doubles(values: readonly number[]): void {
    this.#exports.HEAPF64.set(values, this.#scratch >> 3);
  }

  #putCamera(c: Camera): void {
    this.#doubles([...c.target, c.distance, c.azimuth, c.elevation, c.roll, c.fieldOfView]);
  }

  #takeCamera(): Camera {
    const at = this.#scratch >> 3;
    const [x = 0, y = 0, z = 0, distance = 1, azimuth = 0, elevation = 0, roll = 0, view = 30] =
      this.#exports.HEAPF64.subarray(at, at + 8);
    return { target: [x, y, z], distance, azimuth, elevation, roll, fieldOfView: view };
  }

  #takeStatistics(): DrawStatistics {
    const at = this.#scratch >> 3;
    const n = this.#exports.HEAPF64;
    return {
      samplesDrawn: n[at] ?? 0,
      samplesResident: n[at + 1] ?? 0,
      gpuBytes: n[at + 2] ?? 0,
      chunksDrawn: n[at + 3] ?? 0,
      chunksCulled: n[at + 4] ?? 0,
      drawCalls: n[at + 5] ?? 0,
      kind: splatKinds[n[at + 6] ?? 0] ?? "quad",
      programsLinked: n[at + 7] ?? 0,
    };
  }

  /** A block of at least so many bytes, 8-byte-aligned, valid until the next call of this. */
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

  #read(pointer: number): string {
    const heap = this.#exports.HEAPU8;
    return new TextDecoder().decode(heap.subarray(pointer, heap.indexOf(0, pointer)));
  }
}
