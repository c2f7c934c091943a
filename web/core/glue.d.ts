/** The module that Emscripten writes beside isosplat-core.wasm. */
declare module "*/isosplat-core.js" {
  const createModule: (options: object) => Promise<unknown>;
  export default createModule;
}

/** The same for isosplat-renderer.wasm. */
declare module "*/isosplat-renderer.js" {
  const createModule: (options: object) => Promise<unknown>;
  export default createModule;
}
