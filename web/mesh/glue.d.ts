/** The module that Emscripten writes beside isosplat-mesh.wasm. */
declare module "*/isosplat-mesh.js" {
  const createModule: (options: object) => Promise<unknown>;
  export default createModule;
}
