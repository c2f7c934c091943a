import { fileURLToPath } from "node:url";
import { build, type Rollup } from "vite";
import type { PageBuild } from "../offline/page_cache.ts";

const source = fileURLToPath(new URL("../offline/service_worker.ts", import.meta.url));

/** The script of the service worker for a build of the page: one file, which imports nothing. */
export async function serviceWorker(page: PageBuild): Promise<string> {
  const built = (await build({
    configFile: false,
    logLevel: "error",
    define: { pageBuild: JSON.stringify(page) },
    build: {
      write: false,
      target: "es2022",
      rolldownOptions: { input: source, output: { format: "iife" } },
    },
  })) as Rollup.RollupOutput;
  const [chunk] = built.output;
  return chunk.code;
}
