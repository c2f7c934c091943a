/**
 * The bytes of a file: URL, which Node does not fetch. Node's module is not imported, since bundlers
 * for browsers would try to resolve it.
 */
export async function fileBytes(url: URL): Promise<Uint8Array | undefined> {
  if (url.protocol !== "file:") return undefined;
  return globalThis.process?.getBuiltinModule?.("node:fs/promises").readFile(url);
}
