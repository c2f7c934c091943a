/** Several servers behind one nginx, with the configuration that the packages have. */
import { execFileSync } from "node:child_process";
import { once } from "node:events";
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import type { ClientHttp2Session, IncomingHttpHeaders } from "node:http2";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { program, type RunningServer, serve } from "../browser/support/server.ts";
import {
  connectToProxy,
  hasPackagedNginx,
  type PackagedNginx,
  startPackagedNginx,
} from "../support/packaged_nginx.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const token = "0123456789abcdef-all-volumes";
const client = "127.0.0.5";
const volumes = Array.from({ length: 24 }, (_, i) => `volume-${i}`);

describe.skipIf(!hasPackagedNginx)("three servers behind nginx", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-cluster-"));
  const key = join(folder, "link-key");
  const servers: RunningServer[] = [];
  let proxy: PackagedNginx | undefined;
  let session: ClientHttp2Session;

  async function get(path: string, headers: Record<string, string> = {}) {
    const stream = session.request({ ":path": path, ...headers });
    const [answer] = (await once(stream, "response")) as [IncomingHttpHeaders];
    const parts: Buffer[] = [];
    for await (const part of stream) parts.push(part as Buffer);
    return { status: Number(answer[":status"]), headers: answer, body: Buffer.concat(parts) };
  }

  interface Line {
    target: string;
    address: string;
  }
  const log = (server: number): Line[] =>
    readFileSync(join(folder, `log-${server}`), "utf8")
      .split("\n")
      .filter((line) => line !== "")
      .map((line) => JSON.parse(line) as Line);

  /**
   * Requests each volume twice. Returns the servers that answered, according to the new lines of
   * their logs.
   */
  async function homes(): Promise<Map<string, Set<number>>> {
    const before = servers.map((_, i) => log(i).length);
    for (const volume of [...volumes, ...volumes]) {
      const answer = await get(`/v1/volumes/${volume}`, { authorization: `Bearer ${token}` });
      expect(answer.status, volume).toBe(200);
    }
    const lines = () => servers.map((_, i) => log(i).slice(before[i]));
    await expect.poll(() => lines().flat().length).toBe(2 * volumes.length);
    return new Map(
      volumes.map((volume) => [
        volume,
        new Set(
          lines().flatMap((part, i) =>
            part.some((line) => line.target === `/v1/volumes/${volume}`) ? [i] : [],
          ),
        ),
      ]),
    );
  }

  beforeAll(async () => {
    const stores = join(folder, "stores");
    mkdirSync(stores);
    for (const volume of volumes) {
      copyFileSync(join(root, "tests/golden/v1.0/u8.isosplat"), join(stores, `${volume}.isosplat`));
    }
    writeFileSync(join(folder, "tokens"), `${token} *\n`);
    writeFileSync(key, "0123456789abcdef0123456789abcdef\n");
    mkdirSync(join(folder, "page"));
    writeFileSync(join(folder, "page/index.html"), "<!doctype html><title>page</title>");
    for (let i = 0; i < 3; ++i) {
      // biome-ignore format: options with their values
      servers.push(await serve([stores], 0, [
        "--allow-host", "volumes.example", "--trusted-proxy", "127.0.0.1", "--cookie-name", "isosplat",
        "--token-file", join(folder, "tokens"), "--link-key-file", key,
        "--access-log", join(folder, `log-${i}`), "--log-format", "json",
        "--web-root", join(folder, "page"),
      ]));
    }
    const [a = "", b = "", c = ""] = servers.map((server) => new URL(server.url).port);
    proxy = await startPackagedNginx(folder, "", { cluster: [a, b, c] });
    session = await connectToProxy(proxy, client);
  }, 60_000);

  afterAll(async () => {
    session?.destroy();
    await proxy?.stop();
    for (const server of servers) await server.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  test("a signed link and its cookie are valid on each server", async () => {
    for (const volume of volumes.slice(0, 8)) {
      const arguments_ = [
        "sign-link",
        volume,
        "--link-key-file",
        key,
        "--url",
        "https://v.example",
      ];
      const link = new URL(execFileSync(program, arguments_, { encoding: "utf8" }).trim());
      const page = await get(`/${link.search}`);
      expect(page.status).toBe(200);
      const cookie = page.headers["set-cookie"]?.[0]?.split(";")[0] ?? "";
      expect(cookie).toMatch(new RegExp(`^isosplat-link-${volume}=`));
      expect((await get(`/v1/volumes/${volume}`, { cookie })).status).toBe(200);
      expect((await get(`/v1/volumes/${volume}`)).status).toBe(401);
    }
    expect((await get(`/?token=${token}`)).headers["set-cookie"]?.[0]).toMatch(/; Secure$/);
  });

  test("each volume has one server, which knows the client's address", async () => {
    const before = await homes();
    for (const [volume, home] of before) expect(home.size, volume).toBe(1);
    expect(new Set([...before.values()].flatMap((home) => [...home])).size).toBe(3);
    expect(new Set(servers.flatMap((_, i) => log(i)).map((line) => line.address))).toEqual(
      new Set([client]),
    );
    // If one server stops, only its volumes move to others.
    const gone = 1;
    await servers[gone]?.stop();
    const after = await homes();
    for (const [volume, home] of after) {
      if (before.get(volume)?.has(gone)) {
        expect(home.has(gone), volume).toBe(false);
      } else {
        expect(home, volume).toEqual(before.get(volume));
      }
    }
  });
});
