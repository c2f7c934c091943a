import { compiledOnce } from "../core/compile_asset.ts";
import { type CompiledModule, instantiate, type ModuleFactory } from "../core/instantiate.ts";

/**
 * The functions that a build calls in its environment. Their exceptions become the error of the call.
 */
export interface BuilderHost {
  /** Fills `into` with the slices [first, first + count): little-endian voxels, x fastest. */
  readSlices(first: number, count: number, into: Uint8Array): void;
  /**
   * Takes a part of the store. Parts arrive in ascending order, except the header, which arrives last.
   */
  write(offset: number, bytes: Uint8Array): void;
  progress(fraction: number, voxelsPerSecond: number, secondsLeft: number): void;
}

/** The exports of isosplat-builder.wasm: shared/bindings/wasm/builder_api.h. */
export interface BuilderModule {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(at: number): void;
  _isosplat_builder_create(): number;
  _isosplat_builder_destroy(builder: number): void;
  _isosplat_builder_error(builder: number): number;
  _isosplat_builder_status_name(status: number): number;
  _isosplat_builder_result(builder: number, buffer: number): number;
  _isosplat_builder_result_bytes(builder: number, buffer: number): number;
  _isosplat_builder_begin(builder: number, volume: number, bytes: number): number;
  _isosplat_builder_next(builder: number): number;
  _isosplat_builder_add(builder: number, block: number, bytes: number): number;
  _isosplat_builder_add_statistics(builder: number, statistics: number, bytes: number): number;
  _isosplat_builder_finish(builder: number): number;
  _isosplat_builder_set_up(builder: number, setup: number, bytes: number): number;
  _isosplat_builder_encode(builder: number, task: number, bytes: number): number;
  _isosplat_builder_statistics(builder: number): number;
}

const fetched = compiledOnce(
  "isosplat-builder.wasm",
  () => new URL("../../build/wasm/web/isosplat-builder.wasm", import.meta.url),
);

/**
 * Compiles the module, once for all workers. `bytes`: the content of isosplat-builder.wasm; if it is
 * omitted, the file is fetched.
 */
export async function compileBuilder(bytes?: BufferSource): Promise<CompiledModule> {
  return bytes ? WebAssembly.compile(bytes) : fetched();
}

/** Makes an instance. Encoders need no host. */
export async function instantiateBuilder(
  program: CompiledModule,
  host?: BuilderHost,
): Promise<BuilderModule> {
  const { default: factory } = await import("../../build/wasm/web/isosplat-builder.js");
  const create = factory as (options: object) => Promise<unknown>;
  const withHost: ModuleFactory = (options) => create({ ...options, host });
  return instantiate<BuilderModule>(withHost, program);
}
