/** A store on a plain web server: nginx without settings except for the folder. */
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { FileSource } from "../../web/stream/index.ts";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";
import { core as load, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

describe.skipIf(!hasNginx)("a store on nginx", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-store-"));
  let server: Nginx;

  beforeAll(async () => {
    writeFileSync(join(folder, "store.isosplat"), storeBytes());
    server = await nginx({ folders: [folder] });
  });

  afterAll(async () => {
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("streams to the viewer, neighbouring chunks in one request", async () => {
    const harness = new Harness();
    const source = new FileSource(`${server.url}store.isosplat`);
    const session = await harness.open(source, await load(), { firstIsovalues: [100.5] });
    try {
      session.update(view(100.5));
      await harness.complete();
      expect(harness.errors).toEqual([]);
      expect(harness.progress?.finestLevel).toBe(0);
      const ranges = (await server.accessLog()).filter((line) => line.includes('" 206 '));
      expect(ranges.length).toBe(source.requests);
      expect(source.requests).toBeLessThan(harness.resident.size);
    } finally {
      harness.close();
    }
  });
});
