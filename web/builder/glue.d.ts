/** The module that Emscripten writes beside isosplat-builder.wasm. */
declare module "*/isosplat-builder.js" {
  const createModule: (options: object) => Promise<unknown>;
  export default createModule;
}
