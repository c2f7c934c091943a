/** The server behind nginx, with the configuration that the packages have. */
import { once } from "node:events";
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import type { ClientHttp2Session, IncomingHttpHeaders } from "node:http2";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { type RunningServer, serve } from "../browser/support/server.ts";
import {
  connectToProxy,
  hasPackagedNginx,
  type PackagedNginx,
  startPackagedNginx,
} from "../support/packaged_nginx.ts";
import { writtenLog } from "../support/written_log.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const token = "0123456789abcdef-all-volumes";

interface Answer {
  status: number;
  headers: IncomingHttpHeaders;
  body: Buffer;
}

describe.skipIf(!hasPackagedNginx)("behind nginx, over HTTP/2", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-proxy-"));
  const log = join(folder, "access.log");
  let server: RunningServer;
  let proxy: PackagedNginx | undefined;
  let session: ClientHttp2Session;
  let content = "";
  let secret = "";

  async function get(path: string, headers: Record<string, string> = {}): Promise<Answer> {
    const stream = session.request({ ":path": path, ...headers });
    const [answer] = (await once(stream, "response")) as [IncomingHttpHeaders];
    const parts: Buffer[] = [];
    for await (const part of stream) parts.push(part as Buffer);
    return { status: Number(answer[":status"]), headers: answer, body: Buffer.concat(parts) };
  }

  /** The lines of the server's log, which lacks the requests that the cache answered. */
  const served = async () => {
    const lines = await writtenLog(log, (name) => get(`/v1/volumes/open?${name}`));
    return lines.map((line) => JSON.parse(line) as { target: string; id: string; status: number });
  };
  const requestsOf = async (path: string): Promise<number> =>
    (await served()).filter(({ target }) => target === path).length;

  beforeAll(async () => {
    const store = join(root, "tests/golden/v1.0/u8.isosplat");
    copyFileSync(store, join(folder, "open.isosplat"));
    copyFileSync(store, join(folder, "closed.isosplat"));
    writeFileSync(join(folder, "tokens"), `anyone open\n${token} *\n`);
    mkdirSync(join(folder, "page/assets"), { recursive: true });
    writeFileSync(join(folder, "page/index.html"), "<!doctype html><title>page</title>");
    writeFileSync(join(folder, "page/assets/app-0123abcd.js"), "// long\n".repeat(1000));
    // biome-ignore format: options with their values
    server = await serve([folder], 0, [
      "--allow-host", "volumes.example", "--trusted-proxy", "127.0.0.1",
      "--token-file", join(folder, "tokens"), "--access-log", log, "--log-format", "json",
      "--web-root", join(folder, "page"),
    ]);
    proxy = await startPackagedNginx(folder, new URL(server.url).port);
    session = await connectToProxy(proxy);
    const volume = JSON.parse((await get("/v1/volumes/open")).body.toString());
    content = `/v1/volumes/open/${volume.contentId}`;
    secret = `/v1/volumes/closed/${volume.contentId}`;
  }, 60_000);

  afterAll(async () => {
    session?.destroy();
    await proxy?.stop();
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("content that never changes is fetched from the server once", async () => {
    const path = `${content}/chunks?isovalue=100..120&level=0`;
    const first = await get(path);
    const second = await get(path);
    expect([first.status, second.status]).toEqual([200, 200]);
    expect([first.headers["x-cache"], second.headers["x-cache"]]).toEqual(["MISS", "HIT"]);
    expect(second.body.equals(first.body)).toBe(true);
    expect(second.headers["cache-control"]).toContain("immutable");
    expect(await requestsOf(path)).toBe(1);
  });

  test("the page's files are fetched once for each encoding, the page itself each time", async () => {
    const path = "/assets/app-0123abcd.js";
    const ask = async (encoding: string) => {
      const { headers, body } = await get(path, { "accept-encoding": encoding });
      return [headers["x-cache"], headers["content-encoding"], body.length];
    };
    const [, , whole] = await ask("identity");
    const [miss, , packed] = await ask("gzip");
    expect([miss, packed]).toEqual(["MISS", expect.any(Number)]);
    expect(packed).toBeLessThan(Number(whole));
    expect(await ask("gzip")).toEqual(["HIT", "gzip", packed]);
    expect(await ask("identity")).toEqual(["HIT", undefined, whole]);
    expect(await requestsOf(path)).toBe(2);
    for (let i = 0; i < 2; ++i) expect((await get("/")).headers["x-cache"]).toBeUndefined();
    expect(await requestsOf("/")).toBe(2);
  });

  test("ranges of the file are the file's bytes, also from the cache", async () => {
    const file = readFileSync(join(folder, "open.isosplat"));
    for (const cached of [false, true]) {
      const part = await get(`${content}/file`, { range: "bytes=100-299" });
      expect(part.status).toBe(206);
      expect(part.headers["content-range"]).toBe(`bytes 100-299/${file.length}`);
      expect(part.body.equals(file.subarray(100, 300))).toBe(true);
      if (cached) expect(part.headers["x-cache"]).toBe("HIT");
    }
    const whole = await get(`${content}/file`);
    expect(whole.status).toBe(200);
    expect(whole.body.equals(file)).toBe(true);
  });

  test("content that needs a token is not kept for others", async () => {
    const authorization = `Bearer ${token}`;
    for (const path of [`${secret}/header`, `${secret}/file`]) {
      const first = await get(path, { authorization });
      expect(first.status).toBe(200);
      expect(first.headers["cache-control"]).toContain("private");
      expect((await get(path, { authorization })).headers["x-cache"]).not.toBe("HIT");
      expect((await get(path)).status).toBe(401);
    }
  });

  test("metrics are not for the proxy's clients", async () => {
    expect((await get("/metrics")).status).toBe(404);
    // Try a spelling that nginx decodes to the same path, and one that it does not.
    expect((await get("/%6detrics")).status).toBe(404);
    expect([401, 404]).toContain((await get("/metrics/")).status);
    expect((await get("/readyz")).status).toBe(200);
  });

  test("other host names, and pages of other sites, are refused", async () => {
    expect((await get("/v1/volumes", { ":authority": "evil.example" })).status).toBe(403);
    const cross = { origin: "https://evil.example", "sec-fetch-site": "cross-site" };
    expect((await get("/v1/volumes", cross)).status).toBe(403);
    expect((await get("/v1/volumes", { "sec-fetch-site": "same-origin" })).status).toBe(200);
  });

  test("the server's log has the ids that nginx made", async () => {
    await get("/v1/volumes/open?unique");
    const ids = (await served()).map(({ id }) => id);
    expect(ids.length).toBeGreaterThan(3);
    expect(new Set(ids).size).toBe(ids.length);
    // Requests in pieces (slices) have the id of their request.
    for (const id of ids) expect(id).toMatch(/^[0-9a-f]{32}$/);
  });
});
