import { assetInBase } from "./assets.ts";
import { fileBytes } from "./file_bytes.ts";
import type { CompiledModule } from "./instantiate.ts";

/**
 * A file of the page cannot be fetched, or is not the expected file. The message contains its address.
 */
export class AssetError extends Error {
  override readonly name = "AssetError";
  /**
   * unreachable: no response. server-fault: an unexpected response. renderer-failed: it cannot be
   * compiled.
   */
  readonly kind: "unreachable" | "server-fault" | "renderer-failed";
  constructor(kind: AssetError["kind"], message: string, cause?: unknown) {
    super(message, { cause });
    this.kind = kind;
  }
}

/**
 * Fetches and compiles a WebAssembly file at the first call, or, after a failure, at the next call.
 * `beside` gives its address if no asset base is set: `() => new URL("…", import.meta.url)`. Rejects
 * with an AssetError.
 */
export function compiledOnce<Module = CompiledModule>(
  name: string,
  beside: () => URL,
): () => Promise<Module> {
  let compiled: Promise<CompiledModule> | undefined;
  return () => {
    if (!compiled) {
      compiled = compileAsset(assetInBase(name) ?? beside());
      compiled.catch(() => {
        compiled = undefined;
      });
    }
    return compiled as Promise<Module>;
  };
}

/** Rejects with an AssetError. Also reads file: URLs, which Node's fetch does not support. */
export async function compileAsset(url: URL): Promise<CompiledModule> {
  try {
    const file = await fileBytes(url);
    return await (file ? WebAssembly.compile(file as BufferSource) : fetched(url));
  } catch (error) {
    if (error instanceof AssetError) throw error;
    const text = `${url.href}: expected WebAssembly that this page may compile, found: ${messageOf(error).replace(/\.+$/, "")}`;
    const policy = "A Content-Security-Policy has to allow script-src 'wasm-unsafe-eval'.";
    throw new AssetError("renderer-failed", `${text}. ${policy}`, error);
  }
}

/**
 * Compiles a response while it arrives. Streaming compilation refuses .wasm files with another MIME
 * type, which some hosts send.
 */
async function fetched(url: URL): Promise<CompiledModule> {
  const response = await fetch(url).catch((cause) => {
    const text = `${url.href}: a part of the viewer cannot be fetched: ${messageOf(cause)}`;
    throw new AssetError("unreachable", text, cause);
  });
  const type = response.headers.get("content-type") ?? "";
  if (!response.ok || type.startsWith("text/html")) {
    const found = response.ok ? "found a page" : `found status ${response.status}`;
    const text = `expected a part of the viewer at ${url.href}, ${found}`;
    // Vite up to version 7 copies the package's scripts there, but not its other files.
    const remedy = /\/\.?vite\//.test(url.pathname)
      ? 'this is Vite\'s cache of dependencies: set optimizeDeps: { exclude: ["isosplat"] }'
      : "its bundler has not placed the file";
    const advice = `load the page again; if that does not help, ${remedy}`;
    throw new AssetError("server-fault", `${text}: ${advice}`);
  }
  if (type.startsWith("application/wasm")) return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
