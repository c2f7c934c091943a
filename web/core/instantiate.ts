/** Emscripten's module factories, as far as they are used here. */
export type ModuleFactory = (options: {
  instantiateWasm(
    imports: WebAssembly.Imports,
    receive: (instance: WebAssembly.Instance, program: WebAssembly.Module) => void,
  ): object;
}) => Promise<unknown>;

/**
 * An instance of compiled code, with its factory's JavaScript around it. Rejects when it cannot be
 * made, which Emscripten's own way does not say.
 */
export function instantiate<Exports>(
  factory: ModuleFactory,
  program: WebAssembly.Module,
): Promise<Exports> {
  return new Promise((resolve, reject) => {
    factory({
      instantiateWasm: (imports, receive) => {
        WebAssembly.instantiate(program, imports).then(
          (instance) => receive(instance, program),
          reject,
        );
        return {};
      },
    }).then((exports) => resolve(exports as Exports), reject);
  });
}
