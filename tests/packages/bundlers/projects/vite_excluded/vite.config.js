// Before version 8, the development server bundles dependencies in a way that loses their files.
export default { optimizeDeps: { exclude: ["isosplat"] } };
