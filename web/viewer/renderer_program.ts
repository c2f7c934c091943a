import { AssetError, compiledOnce } from "../core/compile_asset.ts";
import { instantiate, type ModuleFactory } from "../core/instantiate.ts";
import type { CoreModule } from "../core/module.ts";
import { RendererError } from "./renderer_error.ts";

/** The instance that Emscripten's factory creates: the functions of shared/bindings/wasm/renderer_api.h. */
export interface RendererExports extends CoreModule {
  HEAPU8: Uint8Array;
  HEAPU32: Uint32Array;
  /** Emscripten's names of elements, which take precedence over selectors. */
  specialHTMLTargets: Record<string, EventTarget>;
  _malloc(bytes: number): number;
  _free(pointer: number): void;
  _isosplat_renderer_create(selector: number): number;
  _isosplat_renderer_destroy(): void;
  _isosplat_renderer_is_compiled(): number;
  _isosplat_renderer_warm_up(): number;
  _isosplat_renderer_error(): number;
  _isosplat_renderer_set_volume(volume: number, record: number): number;
  _isosplat_renderer_move_volume(volume: number, record: number): number;
  _isosplat_renderer_remove_volume(volume: number): void;
  _isosplat_renderer_reserve_chunk(
    volume: number,
    handle: number,
    block: number,
    clusters: number,
    clusterBytes: number,
    offset: number,
  ): number;
  _isosplat_renderer_bind_samples(volume: number, handle: number, range: number): number;
  _isosplat_renderer_set_field(volume: number, record: number): number;
  _isosplat_renderer_reserve_chunk_field(
    volume: number,
    handle: number,
    samples: number,
    offset: number,
  ): number;
  _isosplat_renderer_check_gpu(): number;
  _isosplat_renderer_remove_chunk(volume: number, handle: number): void;
  _isosplat_renderer_set_visible(volume: number, chunks: number, count: number): void;
  _isosplat_renderer_set_isosurfaces(volume: number, isosurfaces: number, count: number): void;
  _isosplat_renderer_set_splats(kind: number, shading: number): void;
  _isosplat_renderer_set_appearance(appearance: number): void;
  _isosplat_renderer_set_categories(first: number, colours: number, count: number): void;
  _isosplat_renderer_set_light(light: number): void;
  _isosplat_renderer_set_clipping(box: number, planes: number, count: number): void;
  _isosplat_renderer_set_slices(
    volume: number,
    planes: number,
    count: number,
    low: number,
    high: number,
    mapped: number,
  ): void;
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
    pictures: number,
    rgba: number,
  ): number;
  _isosplat_renderer_end_tiles(): void;
  _isosplat_renderer_hold_picture(): number;
  _isosplat_renderer_begin_fade(hasBegun: number): number;
  _isosplat_renderer_fade(progress: number): number;
  _isosplat_renderer_begin_occlusion_query(
    volume: number,
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

/**
 * The compiled code of the module. Fetches and compiles it once; an early call saves time later. Rejects
 * with an AssetError; after a failure the next call tries again.
 */
export const compiledRenderer = compiledOnce<WebAssembly.Module>(
  "isosplat-renderer.wasm",
  () => new URL("../../build/wasm/web/isosplat-renderer.wasm", import.meta.url),
);

/** Fetches the program and creates an instance of it. Rejects with a RendererError. */
export async function instantiateRenderer(): Promise<RendererExports> {
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
  return instantiate<RendererExports>(factory as ModuleFactory, wasm);
}
