export default defineNuxtConfig({
  vue: { compilerOptions: { isCustomElement: (tag) => tag === "isosplat-viewer" } },
  vite: { optimizeDeps: { exclude: ["isosplat"] } },
});
