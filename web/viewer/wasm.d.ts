/** Built by the CMake preset `wasm` into build/wasm/web. */
declare module "@wasm/*.js" {
  const factory: (options: object) => Promise<unknown>;
  export default factory;
}
declare module "@wasm/*.wasm?url" {
  const url: string;
  export default url;
}
