/** A static site from `isosplat publish`, on nginx: finding stores by its catalog. */
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { SiteSource, StreamError } from "../../web/stream/index.ts";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";
import { core as load, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

const otherStore = "tests/golden/v1.0/u8.isosplat";
const program = process.env.ISOSPLAT ?? "build/release/native/cli/isosplat";

describe.skipIf(!hasNginx || !existsSync(program))("a volume of a static site", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-site-"));
  const { signal } = new AbortController();
  let server: Nginx;

  const publish = (store: Uint8Array): void => {
    writeFileSync(join(folder, "head.isosplat"), store);
    const to = ["--to", join(folder, "site"), "--web-root", join(folder, "page")];
    const call = ["publish", join(folder, "head.isosplat"), ...to, "--prune"];
    execFileSync(program, call, { stdio: "ignore" });
  };
  const open = (volume: string) => new SiteSource({ catalog: `${server.url}catalog.json`, volume });

  beforeAll(async () => {
    mkdirSync(join(folder, "page"));
    writeFileSync(join(folder, "page/index.html"), "<html><head></head></html>");
    publish(storeBytes());
    server = await nginx({ folders: [join(folder, "site")] });
  });

  afterAll(async () => {
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("streams from the file that the catalog names", async () => {
    const harness = new Harness();
    const session = await harness.open(open("head"), await load(), { firstIsovalues: [100.5] });
    try {
      session.update(view(100.5));
      await harness.complete();
      expect(harness.errors).toEqual([]);
      expect(harness.progress?.finestLevel).toBe(0);
    } finally {
      harness.close();
    }
  });

  test("a volume that is published again has another content id, and is read again", async () => {
    const source = open("head");
    const before = await source.contentId(signal);
    const old = await source.header(signal);
    publish(readFileSync(otherStore));
    expect(await source.contentId(signal)).not.toBe(before);
    source.forget();
    expect(await source.header(signal)).not.toEqual(old);
  });

  test("names that the catalog lacks, and files that are not catalogs, are errors", async () => {
    await expect(open("other").header(signal)).rejects.toThrow(/has no volume other/);
    const page = new SiteSource({ catalog: `${server.url}index.html`, volume: "head" });
    const error = await page.header(signal).catch((reason) => reason);
    expect(error).toBeInstanceOf(StreamError);
    expect(error.kind).toBe("server-fault");
  });
});
