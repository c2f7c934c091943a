import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));

/**
 * The page. `npm run build:page` writes build/page, which the server hands out; `npm run dev` serves
 * it with hot reload and passes /v1 on to a running server (ISOSPLAT_SERVER, default port 8080).
 */
export default defineConfig({
  root: here("web"),
  // Relative addresses: the page works at any path of any static host.
  base: "./",
  resolve: { alias: { "@wasm": here("build/wasm/web") } },
  build: {
    outDir: here("build/page"),
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    // Preloading is done by hand in index.html, so that the first surface does not wait.
    modulePreload: { polyfill: false },
    reportCompressedSize: true,
  },
  worker: { format: "es" },
  server: {
    proxy: { "/v1": process.env.ISOSPLAT_SERVER ?? "http://localhost:8080" },
    fs: { allow: [here(".")] },
  },
});
