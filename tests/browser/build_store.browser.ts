// Builds a store in the workers of a browser. It must equal the program's store, byte by byte.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { expect, test } from "@playwright/test";
import { createServer, type Plugin, type ViteDevServer } from "vite";
import type * as BuilderModule from "../../web/builder/index.ts";
import { loadCore } from "../../web/core/index.ts";
import { describeStore } from "../support/describe_store.ts";
import { demoFolder } from "./support/server.ts";

const nrrd = readFileSync(`${demoFolder}/bucky.nrrd`);
const voxels = nrrd.subarray(nrrd.indexOf("\n\n") + 2);
const store = readFileSync(`${demoFolder}/bucky.isosplat`);

/** Serves /empty, a page without content, and /voxels. */
const files: Plugin = {
  name: "volume",
  configureServer: ({ middlewares }) => {
    middlewares.use("/empty", (_request, response) => {
      response.setHeader("Content-Type", "text/html");
      response.end("<!doctype html>");
    });
    middlewares.use("/voxels", (_request, response) => response.end(voxels));
  },
};

let modules: ViteDevServer;
let volume: BuilderModule.VolumeDescription;
test.beforeAll(async () => {
  volume = describeStore(await loadCore(), store);
  modules = await createServer({
    configFile: "vite.config.ts",
    server: { port: 0, hmr: false },
    plugins: [files],
    optimizeDeps: { noDiscovery: true, include: [] },
  });
  await modules.listen();
});
test.afterAll(() => modules.close());
test.beforeEach(({ page }) => page.goto(`${modules.resolvedUrls?.local[0]}empty`));

test("a Blob becomes the program's store, and the workers end", async ({ page }) => {
  const built = await page.evaluate(async (described) => {
    const { buildStore } = (await import("/builder/index.ts" as string)) as typeof BuilderModule;
    const blob = await (await fetch("/voxels")).blob();
    const fractions: number[] = [];
    const { store: bytes, report } = await buildStore(described, blob, {
      workers: 2,
      progress: ({ fraction }) => fractions.push(fraction),
    });
    const digest = await crypto.subtle.digest("SHA-256", await bytes.arrayBuffer());
    const hash = Array.from(new Uint8Array(digest), (byte) => byte.toString(16).padStart(2, "0"));
    return { report, fractions, hash: hash.join("") };
  }, volume);
  expect(built.hash).toBe(createHash("sha256").update(store).digest("hex"));
  expect(built.report.storeBytes).toBe(store.byteLength);
  expect(built.fractions).toEqual([...built.fractions].sort((a, b) => a - b));
  await expect.poll(() => page.workers().length).toBe(0);
});

test("a build that is cancelled or fails ends its workers and states the reason", async ({
  page,
}) => {
  const reasons = await page.evaluate(async (described) => {
    const { buildStore } = (await import("/builder/index.ts" as string)) as typeof BuilderModule;
    const blob = await (await fetch("/voxels")).blob();
    const reason = (build: Promise<unknown>) =>
      build.then(
        () => "built",
        (error: unknown) => String(error),
      );
    const cancel = new AbortController();
    const cancelled = buildStore(described, blob, {
      workers: 2,
      signal: cancel.signal,
      progress: () => cancel.abort(),
    });
    return [
      await reason(cancelled),
      await reason(buildStore(described, blob.slice(1), { workers: 1 })),
      await reason(buildStore(described, blob, { workers: 1, memoryBytes: 2 ** 20 })),
    ];
  }, volume);
  expect(reasons[0]).toContain("AbortError");
  expect(reasons[1]).toContain("the file is incomplete, or its header is wrong");
  expect(reasons[2]).toContain("build it with the program");
  await expect.poll(() => page.workers().length).toBe(0);
});
