import type { CompiledModule } from "../core/instantiate.ts";

/** Fetches and compiles a WebAssembly module at the first call; after a failure, at the next one. */
export function compiledOnce(url: () => URL): () => Promise<CompiledModule> {
  let compiled: Promise<CompiledModule> | undefined;
  return () => {
    compiled ??= WebAssembly.compileStreaming(fetch(url()));
    compiled.catch(() => {
      compiled = undefined;
    });
    return compiled;
  };
}
