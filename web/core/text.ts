/** A zero-terminated UTF-8 string in the memory of a WebAssembly module. */
export function textAt(module: { HEAPU8: Uint8Array }, at: number): string {
  const heap = module.HEAPU8;
  return new TextDecoder().decode(heap.slice(at, heap.indexOf(0, at)));
}
