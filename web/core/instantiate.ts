/** WebAssembly.Module, or `object` in projects with the types of Node alone, which lack it. */
export type CompiledModule = typeof globalThis extends {
  WebAssembly: { Module: { prototype: infer Module } };
}
  ? Module
  : object;

/** The part of Emscripten's module factories that is used here. */
export type ModuleFactory = (options: {
  instantiateWasm(
    imports: object,
    receive: (instance: object, program: CompiledModule) => void,
  ): object;
}) => Promise<unknown>;

/**
 * Creates an instance of compiled code with Emscripten's factory. Rejects if the instantiation fails;
 * the factory alone would not report it.
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
