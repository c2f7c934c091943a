/** The module that Emscripten writes beside isosplat-import.wasm. */
declare module "*/isosplat-import.js" {
  const createModule: (options: object) => Promise<unknown>;
  export default createModule;
}
