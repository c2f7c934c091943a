/** The server behind Caddy, with the configuration that the packages have: HTTP/2 and HTTP/3. */
import { once } from "node:events";
import {
  copyFileSync,
  existsSync,
  mkdtempSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { type ClientHttp2Session, connect, type IncomingHttpHeaders } from "node:http2";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "@playwright/test";
import { afterAll, beforeAll, describe, expect, test, vi } from "vitest";
import { launchOptions } from "../browser/support/chromium.ts";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { type Caddy, hasCaddy, startCaddy } from "../support/caddy.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const store = join(root, "tests/golden/v1.0/u8.isosplat");
const token = "0123456789abcdef-all-volumes";

describe.skipIf(!hasCaddy)("behind Caddy", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-caddy-"));
  const log = join(folder, "access.log");
  let server: RunningServer;
  let caddy: Caddy;
  let session: ClientHttp2Session;
  let origin = "";
  let content = "";

  async function get(path: string, headers: Record<string, string> = {}) {
    const stream = session.request({ ":path": path, ...headers });
    const [answer] = (await once(stream, "response")) as [IncomingHttpHeaders];
    const parts: Buffer[] = [];
    for await (const part of stream) parts.push(part as Buffer);
    return { status: Number(answer[":status"]), headers: answer, body: Buffer.concat(parts) };
  }

  beforeAll(async () => {
    copyFileSync(store, join(folder, "open.isosplat"));
    copyFileSync(store, join(folder, "closed.isosplat"));
    writeFileSync(join(folder, "tokens"), `anyone open\n${token} *\n`);
    // biome-ignore format: options with their values
    server = await serve([folder], 0, [
      "--allow-host", "volumes.example", "--trusted-proxy", "127.0.0.1",
      "--token-file", join(folder, "tokens"), "--access-log", log, "--log-format", "json",
    ]);
    caddy = await startCaddy(folder, Number(new URL(server.url).port));
    origin = `https://volumes.example:${caddy.port}`;
    session = connect(origin, {
      lookup: (_name, _options, found) => found(null, [{ address: "127.0.0.1", family: 4 }]),
      ca: caddy.certificate,
    });
    await once(session, "connect");
    const volume = JSON.parse((await get("/v1/volumes/open")).body.toString());
    content = `/v1/volumes/open/${volume.contentId}`;
  }, 60_000);

  afterAll(async () => {
    session?.destroy();
    await caddy?.stop();
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("HTTP/2 has the bytes, ranges and fields of the server", async () => {
    const file = readFileSync(store);
    const part = await get(`${content}/file`, { range: "bytes=100-299" });
    expect(part.status).toBe(206);
    expect(part.headers["content-range"]).toBe(`bytes 100-299/${file.length}`);
    expect(part.headers["cache-control"]).toContain("immutable");
    expect(part.body.equals(file.subarray(100, 300))).toBe(true);
    const whole = await get(`${content}/file`);
    expect(whole.body.equals(file)).toBe(true);
    expect(whole.headers["alt-svc"]).toContain("h3=");
  });

  test("tokens pass, and nothing is served without one that needs it", async () => {
    const closed = content.replace("/open/", "/closed/");
    expect((await get(`${closed}/header`)).status).toBe(401);
    const answer = await get(`${closed}/header`, { authorization: `Bearer ${token}` });
    expect(answer.status).toBe(200);
    expect(answer.headers["cache-control"]).toContain("private");
  });

  test("metrics are not for the proxy's clients; pages of other sites are refused", async () => {
    expect((await get("/metrics")).status).toBe(404);
    expect([401, 404]).toContain((await get("/%6detrics")).status);
    const cross = { origin: "https://evil.example", "sec-fetch-site": "cross-site" };
    expect((await get("/v1/volumes", cross)).status).toBe(403);
    expect((await get("/readyz")).status).toBe(200);
  });

  test("the server's log has the ids that Caddy made", async () => {
    await get("/v1/volumes/open");
    // The server writes the file in the background.
    const ids = await vi.waitFor(() => {
      const lines = readFileSync(log, "utf8").trim().split("\n");
      return lines.map((line) => (JSON.parse(line) as { id: string }).id);
    });
    expect(new Set(ids).size).toBe(ids.length);
    for (const id of ids) expect(id).toMatch(/^[0-9a-f-]{36}$/);
  });

  test.skipIf(!existsSync(launchOptions.executablePath ?? ""))(
    "a browser gets the file over HTTP/3",
    async () => {
      const browser = await chromium.launch({
        ...launchOptions,
        args: [
          ...(launchOptions.args ?? []),
          ...caddy.chromiumArguments,
          `--origin-to-force-quic-on=${new URL(origin).host}`,
        ],
      });
      try {
        const page = await browser.newPage();
        await page.goto(`${origin}/healthz`);
        const seen = await page.evaluate(async (path) => {
          const response = await fetch(path, { headers: { Range: "bytes=0-99" } });
          const bytes = [...new Uint8Array(await response.arrayBuffer())];
          const [entry] = performance.getEntriesByType("navigation");
          const protocol = (entry as PerformanceResourceTiming).nextHopProtocol;
          return { status: response.status, bytes, protocol };
        }, `${content}/file`);
        expect(seen.protocol).toBe("h3");
        expect(seen.status).toBe(206);
        expect(Buffer.from(seen.bytes).equals(readFileSync(store).subarray(0, 100))).toBe(true);
      } finally {
        await browser.close();
      }
    },
    60_000,
  );
});
