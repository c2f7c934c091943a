import { compileResponse } from "../core/compile_response.ts";
import type { CompiledModule } from "../core/instantiate.ts";

/**
 * Fetches and compiles a WebAssembly module at the first call; after a failure, at the next one. A
 * module that cannot be had is an error with its address.
 */
export function compiledOnce(url: () => URL): () => Promise<CompiledModule> {
  let compiled: Promise<CompiledModule> | undefined;
  return () => {
    compiled ??= fetchAndCompile(url());
    compiled.catch(() => {
      compiled = undefined;
    });
    return compiled;
  };
}

async function fetchAndCompile(url: URL): Promise<CompiledModule> {
  const response = await fetch(url).catch((cause) => {
    throw new Error(`${url}: a part of the page cannot be fetched; try again`, { cause });
  });
  if (!response.ok) {
    const found = `found status ${response.status}`;
    throw new Error(`expected a part of the page at ${url}, ${found}; load the page again`);
  }
  return compileResponse(response);
}
