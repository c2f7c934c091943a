import { Core } from "./core.ts";
import { type CompiledModule, instantiate, type ModuleFactory } from "./instantiate.ts";
import type { CoreModule } from "./module.ts";

/** Compiled code with the core: isosplat-renderer, which contains it, or isosplat-core. */
export type CoreProgram = { renderer: CompiledModule } | { core: CompiledModule };

/** Makes an instance, in a browser, a worker, or Node. Fetches nothing but the module's JavaScript. */
export async function instantiateCore(program: CoreProgram): Promise<Core> {
  const { default: factory } =
    "renderer" in program
      ? await import("../../build/wasm/web/isosplat-renderer.js")
      : await import("../../build/wasm/web/isosplat-core.js");
  const compiled = "renderer" in program ? program.renderer : program.core;
  return new Core(await instantiate<CoreModule>(factory as ModuleFactory, compiled));
}
