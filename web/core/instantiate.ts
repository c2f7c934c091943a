/** WebAssembly.Module, where the types of a project have it: those of Node alone do not. */
export type CompiledModule = typeof globalThis extends {
  WebAssembly: { Module: { prototype: infer Module } };
}
  ? Module
  : object;

/** Emscripten's module factories, as far as they are used here. */
export type ModuleFactory = (options: {
  instantiateWasm(
    imports: object,
    receive: (instance: object, program: CompiledModule) => void,
  ): object;
}) => Promise<unknown>;

/**
 * An instance of compiled code, with its factory's JavaScript around it. Rejects when it cannot be
 * made, which Emscripten's own way does not say.
 */
export function instantiate<Exports>(
  factory: ModuleFactory,
  program: CompiledModule,
): Promise<Exports> {
  return new Promise((resolve, reject) => {
    factory({
      instantiateWasm: (imports, receive) => {
        WebAssembly.instantiate(program, imports as WebAssembly.Imports).then(
          (instance) => receive(instance, program),
          reject,
        );
        return {};
      },
    }).then((exports) => resolve(exports as Exports), reject);
  });
}
