/** An empty page on which tests use the modules of web/, which Vite serves beside a real server. */
import { createServer, type Plugin, type ViteDevServer } from "vite";

/** Serves /empty, a page with only a canvas. */
const emptyPages: Plugin = {
  name: "empty-pages",
  configureServer: ({ middlewares }) => {
    middlewares.use("/empty", (_request, response) => {
      response.setHeader("Content-Type", "text/html");
      response.end("<!doctype html><canvas></canvas>");
    });
  },
};

/** The URL of the page's server, without a final "/". Close the server after all tests. */
export interface ServedModules {
  origin: string;
  close(): Promise<void>;
}

/** `server`: the address of the server whose /v1 the page reaches. */
export async function serveModules(server: string): Promise<ServedModules> {
  const modules: ViteDevServer = await createServer({
    configFile: "vite.config.ts",
    server: { port: 0, hmr: false, proxy: { "/v1": server } },
    plugins: [emptyPages],
    // The viewer needs no packages; those of the page are not loaded.
    optimizeDeps: { noDiscovery: true, include: [] },
  });
  await modules.listen();
  const origin = (modules.resolvedUrls?.local[0] ?? "").replace(/\/$/, "");
  return { origin, close: () => modules.close() };
}
