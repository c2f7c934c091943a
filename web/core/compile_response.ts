import type { CompiledModule } from "./instantiate.ts";

/**
 * Compiles the module in a response, while it arrives if possible. Some static hosts send .wasm with
 * another type, which compileStreaming rejects.
 */
export async function compileResponse(response: Response): Promise<CompiledModule> {
  const isTyped = response.headers.get("content-type")?.startsWith("application/wasm");
  if (isTyped) return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}
