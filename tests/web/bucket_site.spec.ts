/** Static sites that are published to buckets. */
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import { program } from "../browser/support/server.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { runProgram } from "../support/run_program.ts";
import { S3Service } from "../support/s3_service.ts";
import { nobody, person } from "../support/s3_settings.ts";
import { storeBytes } from "../support/store_bytes.ts";

const bucket = "volumes";
const forEver = "public, max-age=31536000, immutable";

describe.skipIf(!existsSync(program))("a site in a bucket", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-bucket-site-"));
  const page = join(folder, "page");
  const store = join(folder, "head.isosplat");
  let service: S3Service;
  let proxy: FaultProxy;

  const publish = (
    to: string,
    options: readonly string[] = [],
    from = store,
    env: Record<string, string | undefined> = person,
  ) => {
    const args = ["publish", from, "--to", `s3://${bucket}${to}`, "--web-root", page];
    return runProgram([...args, "--endpoint", proxy.url, ...options], env);
  };
  const object = (path: string) => service.get(`${bucket}/${path}`);
  const written = () =>
    proxy.requests
      .filter(({ method }) => method !== "HEAD" && method !== "GET")
      .map(({ path }) => path);

  beforeAll(async () => {
    mkdirSync(join(page, "assets"), { recursive: true });
    writeFileSync(join(page, "index.html"), "<html><head></head></html>");
    writeFileSync(join(page, "assets/a-12345678.js"), "let a;");
    writeFileSync(join(page, "assets/a-12345678.js.br"), "br");
    writeFileSync(join(page, "icon.png"), "png");
    writeFileSync(store, storeBytes());
    service = new S3Service(join(folder, "s3"), bucket);
    await service.start();
  });
  beforeEach(async () => {
    proxy = new FaultProxy(service.url);
    proxy.keepsHost = true;
    await proxy.start();
  });
  afterEach(() => proxy.stop());
  afterAll(async () => {
    await service?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("has the page, the catalog and the stores, with their types and times in caches", async () => {
    const ran = await publish("/a/site/");
    expect(ran.code, ran.stderr).toBe(0);
    const catalog = JSON.parse(String((await object("a/site/catalog.json"))?.bytes)) as {
      volumes: { name: string; urls?: unknown }[];
    };
    expect(catalog.volumes.map(({ name }) => name)).toEqual(["head"]);
    const stored = written().find((path) => path.includes("/stores/head-")) ?? "";
    const found = await service.get(stored.replace(/^\//, "").replace(/\?.*/, ""));
    expect(found?.bytes.equals(storeBytes())).toBe(true);
    expect(found?.headers.get("cache-control")).toBe(forEver);
    const index = await object("a/site/index.html");
    expect(index?.headers.get("content-type")).toBe("text/html; charset=utf-8");
    expect(index?.headers.get("cache-control")).toBe("no-cache");
    expect(String(index?.bytes)).toContain("isosplat-catalog");
    const script = await object("a/site/assets/a-12345678.js");
    expect(script?.headers.get("content-type")).toBe("text/javascript; charset=utf-8");
    expect(script?.headers.get("cache-control")).toBe(forEver);
    expect(await object("a/site/assets/a-12345678.js.br")).toBeUndefined();
    expect(service.refused).toEqual([]);
  });

  test("is written in the order in which visitors need it, and each store once", async () => {
    expect((await publish("/order")).code).toBe(0);
    const first = written();
    expect(first[0]).toContain("/stores/");
    expect(first.slice(-2)).toEqual([
      `/${bucket}/order/catalog.json`,
      `/${bucket}/order/index.html`,
    ]);
    proxy.requests.length = 0;
    const again = await publish("/order");
    expect(again.stdout).toContain("(unchanged)");
    expect(written().filter((path) => path.includes("/stores/"))).toEqual([]);
  });

  test("at the root of the bucket has no prefix", async () => {
    expect((await publish("")).code).toBe(0);
    expect(await object("index.html")).toBeDefined();
  });

  test("stays as it was if a store cannot be sent", async () => {
    expect((await publish("/kept")).code).toBe(0);
    const other = join(folder, "other.isosplat");
    writeFileSync(other, readFileSync("tests/golden/v1.0/u8.isosplat"));
    const before = (await object("kept/catalog.json"))?.bytes;
    const body = "<Error><Code>ExpiredToken</Code></Error>";
    proxy.fault = (path, _number, method) =>
      method !== "HEAD" && path.includes("/stores/other")
        ? { kind: "status", status: 403, body }
        : undefined;
    const ran = await publish("/kept", [], other);
    expect(ran.code).toBe(1);
    expect(ran.stderr).toContain("ExpiredToken");
    expect((await object("kept/catalog.json"))?.bytes).toEqual(before);
  });

  test("replaces no other page without --force", async () => {
    await service.put(`${bucket}/mine/index.html`, Buffer.from("mine"));
    const ran = await publish("/mine");
    expect(ran.code).toBe(2);
    expect(ran.stderr).toContain("expected no index.html, or that of a published site");
    expect(String((await object("mine/index.html"))?.bytes)).toBe("mine");
    expect((await publish("/mine", ["--force"])).code).toBe(0);
  });

  test("replaces no file of another page without --force, even one of the same length", async () => {
    await service.put(`${bucket}/app/icon.png`, Buffer.from("pic"));
    const ran = await publish("/app");
    expect(ran.code).toBe(2);
    expect(ran.stderr).toContain("expected no icon.png, or that of a published site");
    expect(written()).toEqual([]);
    expect(String((await object("app/icon.png"))?.bytes)).toBe("pic");
  });

  test("continues after a publication that was interrupted", async () => {
    await service.put(`${bucket}/half/icon.png`, Buffer.from("png"));
    const ran = await publish("/half");
    expect(ran.code, ran.stderr).toBe(0);
  });

  test("whose catalog cannot be read is one error, which does not recommend --force", async () => {
    expect((await publish("/refused")).code).toBe(0);
    proxy.fault = (path, _number, method) =>
      method === "GET" && path.includes("catalog.json")
        ? { kind: "status", status: 403, body: "<Error><Code>AccessDenied</Code></Error>" }
        : undefined;
    const ran = await publish("/refused");
    expect(ran.code).toBe(1);
    expect(ran.stderr).toContain("AccessDenied");
    expect(ran.stderr).not.toContain("--force");
  });

  test("gets a store again if an object of its name and length has other bytes", async () => {
    expect((await publish("/other")).code).toBe(0);
    const path = written()
      .find((found) => found.includes("/stores/head-"))
      ?.slice(1);
    await service.put(path ?? "", new Uint8Array(storeBytes().length));
    const ran = await publish("/other");
    expect(ran.stdout).not.toContain("(unchanged)");
    expect((await service.get(path ?? ""))?.bytes.equals(storeBytes())).toBe(true);
  });

  test("is not written to a web address", async () => {
    const args = ["publish", store, "--to", "https://user:sesame@a.example/site"];
    const ran = await runProgram([...args, "--web-root", page]);
    expect(ran.code).toBe(2);
    expect(ran.stderr).toContain("--to: expected a folder or s3://BUCKET/PREFIX");
    expect(ran.stderr).not.toContain("sesame");
    expect(existsSync("https:")).toBe(false);
  });

  test("is not pruned, and not written without credentials: one error each, before any write", async () => {
    const pruned = await publish("/no", ["--prune"]);
    expect(pruned.code).toBe(2);
    expect(pruned.stderr).toContain("--prune: expected a folder");
    const anonymous = await publish("/no", [], store, nobody);
    expect(anonymous.code).toBe(2);
    expect(anonymous.stderr).toContain("expected credentials");
    expect(written()).toEqual([]);
  });
});
