/** The module that Emscripten writes beside isosplat-measure.wasm. */
declare module "*/isosplat-measure.js" {
  const createModule: (options: object) => Promise<unknown>;
  export default createModule;
}
