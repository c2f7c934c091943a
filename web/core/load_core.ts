import { compileAsset, compiledOnce } from "./compile_asset.ts";
import { Core } from "./core.ts";
import type { CompiledModule } from "./instantiate.ts";
import { instantiateCore } from "./instantiate_core.ts";
import type { CoreModule } from "./module.ts";

/** The module that provides the core: isosplat-core, or isosplat-renderer, which contains it. */
export interface CoreOptions {
  /** The bytes of isosplat-core.wasm. */
  wasmBinary?: Uint8Array;
  /** The address of isosplat-core.wasm. Default: beside its module, or in the folder of setAssetBase. */
  url?: string;
  /** An existing instance with the functions of the core, such as one of isosplat-renderer. */
  module?: CoreModule;
  /** The compiled code of isosplat-renderer, to create another instance of it. */
  renderer?: CompiledModule;
}

/** The compiled code of isosplat-core. Fetches and compiles it once. Rejects with an AssetError. */
export const compiledCore: () => Promise<CompiledModule> = compiledOnce(
  "isosplat-core.wasm",
  () => new URL("../../build/wasm/web/isosplat-core.wasm", import.meta.url),
);

/** Makes an instance of the core, in a browser, a worker, or Node (20.16 or newer). */
export async function loadCore(options: CoreOptions = {}): Promise<Core> {
  const { module, renderer } = options;
  if (module) return new Core(module);
  if (renderer) return instantiateCore({ renderer });
  return instantiateCore({ core: await compiled(options) });
}

function compiled({ wasmBinary, url }: CoreOptions): Promise<CompiledModule> {
  if (wasmBinary) return WebAssembly.compile(wasmBinary as BufferSource);
  if (url === undefined) return compiledCore();
  return compileAsset(new URL(url, typeof location === "undefined" ? undefined : location.href));
}
