/** The server behind nginx, with the configuration that the packages have. */
import { type ChildProcess, execFileSync, spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { type ClientHttp2Session, connect, type IncomingHttpHeaders } from "node:http2";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { freePort, hasNginx } from "../support/nginx.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const hasOpenssl = spawnSync("openssl", ["version"]).error === undefined;
const token = "0123456789abcdef-all-volumes";

interface Answer {
  status: number;
  headers: IncomingHttpHeaders;
  body: Buffer;
}

describe.skipIf(!hasNginx || !hasOpenssl)("behind nginx, over HTTP/2", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-proxy-"));
  const log = join(folder, "access.log");
  let server: RunningServer;
  let proxy: ChildProcess | undefined;
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

  /** The lines of the server's own log: what the cache answers is not among them. */
  const served = () =>
    readFileSync(log, "utf8")
      .trim()
      .split("\n")
      .map((line) => JSON.parse(line) as { target: string; id: string; status: number });

  beforeAll(async () => {
    const store = join(root, "tests/golden/v1.0/u8.isosplat");
    copyFileSync(store, join(folder, "open.isosplat"));
    copyFileSync(store, join(folder, "closed.isosplat"));
    writeFileSync(join(folder, "tokens"), `anyone open\n${token} *\n`);
    const port = await freePort();
    // biome-ignore format: options with their values
    server = await serve([folder], 0, [
      "--allow-host", "volumes.example", "--connections-per-address", "0",
      "--token-file", join(folder, "tokens"), "--access-log", log, "--log-format", "json",
    ]);
    const behind = new URL(server.url).port;

    // biome-ignore format: options with their values
    execFileSync("openssl", [
      "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
      "-subj", "/CN=volumes.example", "-days", "2",
      "-keyout", join(folder, "key"), "-out", join(folder, "certificate"),
    ], { stdio: "ignore" });
    mkdirSync(join(folder, "cache"));
    // Only paths and ports differ from what the packages have.
    const configuration = readFileSync(join(root, "native/packaging/nginx.conf"), "utf8")
      .replaceAll("/var/cache/nginx/isosplat", join(folder, "cache"))
      .replaceAll("/etc/ssl/volumes.example.pem", join(folder, "certificate"))
      .replaceAll("/etc/ssl/volumes.example.key", join(folder, "key"))
      .replace("127.0.0.1:8080", `127.0.0.1:${behind}`)
      .replace("listen 443 ", `listen 127.0.0.1:${port} `);
    const user = process.getuid?.() === 0 ? "user root;" : "";
    writeFileSync(
      join(folder, "nginx.conf"),
      `daemon off; ${user} pid ${folder}/pid; error_log ${folder}/errors; events {}
      http {
        access_log off;
        client_body_temp_path ${folder}/1; proxy_temp_path ${folder}/2; fastcgi_temp_path ${folder}/3;
        uwsgi_temp_path ${folder}/4; scgi_temp_path ${folder}/5;
        ${configuration}
      }`,
    );
    writeFileSync(join(folder, "errors"), "");
    // biome-ignore format: options with their values
    const started = spawn("/usr/sbin/nginx", [
      "-p", folder, "-c", join(folder, "nginx.conf"), "-e", join(folder, "errors"),
    ], { stdio: "ignore" });
    proxy = started;
    for (let attempt = 0; ; ++attempt) {
      session = connect(`https://volumes.example:${port}`, {
        lookup: (_name, _options, found) => found(null, [{ address: "127.0.0.1", family: 4 }]),
        ca: readFileSync(join(folder, "certificate")),
      });
      const isOpen = await Promise.race([
        once(session, "connect").then(() => true),
        once(session, "error").then(() => false),
      ]).catch(() => false);
      if (isOpen) break;
      if (attempt === 200 || started.exitCode !== null) {
        throw new Error(`nginx did not start: ${readFileSync(join(folder, "errors"), "utf8")}`);
      }
      await new Promise((next) => setTimeout(next, 50));
    }
    const volume = JSON.parse((await get("/v1/volumes/open")).body.toString());
    content = `/v1/volumes/open/${volume.contentId}`;
    secret = `/v1/volumes/closed/${volume.contentId}`;
  }, 60_000);

  afterAll(async () => {
    session?.destroy();
    if (proxy?.exitCode === null) {
      proxy.kill("SIGTERM");
      await once(proxy, "exit");
    }
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("what never changes is fetched from the server once", async () => {
    const path = `${content}/chunks?isovalue=100..120&level=0`;
    const first = await get(path);
    const second = await get(path);
    expect([first.status, second.status]).toEqual([200, 200]);
    expect([first.headers["x-cache"], second.headers["x-cache"]]).toEqual(["MISS", "HIT"]);
    expect(second.body.equals(first.body)).toBe(true);
    expect(second.headers["cache-control"]).toContain("immutable");
    expect(served().filter(({ target }) => target === path).length).toBe(1);
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

  test("what needs a token is not kept for others", async () => {
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
    // By another spelling, which nginx takes for the same path, and by one which it does not.
    expect((await get("/%6detrics")).status).toBe(404);
    expect([401, 404]).toContain((await get("/metrics/")).status);
    expect((await get("/readyz")).status).toBe(200);
  });

  test("names of others, and pages of other sites, are refused", async () => {
    expect((await get("/v1/volumes", { ":authority": "evil.example" })).status).toBe(403);
    const cross = { origin: "https://evil.example", "sec-fetch-site": "cross-site" };
    expect((await get("/v1/volumes", cross)).status).toBe(403);
    expect((await get("/v1/volumes", { "sec-fetch-site": "same-origin" })).status).toBe(200);
  });

  test("the server's log has the ids that nginx made", async () => {
    await get("/v1/volumes/open?unique");
    const ids = served().map(({ id }) => id);
    expect(ids.length).toBeGreaterThan(3);
    expect(new Set(ids).size).toBe(ids.length);
    // Requests in pieces (slices) have the id of their request.
    for (const id of ids) expect(id).toMatch(/^[0-9a-f]{32}$/);
  });
});
