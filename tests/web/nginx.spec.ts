/** A store on a plain web server: nginx, with nothing set but the folder. */
import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { chmodSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import type { AddressInfo } from "node:net";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { FileSource } from "../../web/stream/index.ts";
import { core as load, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

const nginx = ["/usr/sbin/nginx", "nginx"].find(
  (program) => spawnSync(program, ["-v"]).error === undefined,
);

async function freePort(): Promise<number> {
  const server = createServer();
  await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
  const { port } = server.address() as AddressInfo;
  await new Promise((resolve) => server.close(resolve));
  return port;
}

describe.skipIf(!nginx)("a store on nginx", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-nginx-"));
  let server: ChildProcess;
  let url: string;

  beforeAll(async () => {
    const port = await freePort();
    // Started by root, nginx reads as another user.
    chmodSync(folder, 0o755);
    writeFileSync(join(folder, "store.isosplat"), storeBytes());
    writeFileSync(
      join(folder, "nginx.conf"),
      `daemon off; pid ${folder}/pid; error_log ${folder}/errors;
      events {}
      http {
        access_log ${folder}/access;
        client_body_temp_path ${folder}/1; proxy_temp_path ${folder}/2; fastcgi_temp_path ${folder}/3;
        uwsgi_temp_path ${folder}/4; scgi_temp_path ${folder}/5;
        server { listen 127.0.0.1:${port}; root ${folder}; }
      }`,
    );
    server = spawn(nginx ?? "nginx", ["-p", folder, "-c", join(folder, "nginx.conf")]);
    url = `http://127.0.0.1:${port}/store.isosplat`;
    for (let attempt = 0; attempt < 100; ++attempt) {
      if (await fetch(url, { method: "HEAD" }).catch(() => undefined)) return;
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    throw new Error(`nginx did not start: ${readFileSync(join(folder, "errors"), "utf8")}`);
  });

  afterAll(async () => {
    const ended = new Promise((resolve) => server.once("exit", resolve));
    server.kill("SIGTERM");
    await ended;
    rmSync(folder, { recursive: true, force: true });
  });

  test("streams to the viewer, neighbouring chunks in one request", async () => {
    const harness = new Harness();
    const source = new FileSource(url);
    const session = await harness.open(source, await load(), { firstIsovalues: [100.5] });
    try {
      session.update(view(100.5));
      await harness.complete();
      expect(harness.errors).toEqual([]);
      expect(harness.progress?.finestLevel).toBe(0);
      const answers = readFileSync(join(folder, "access"), "utf8").trim().split("\n");
      const ranges = answers.filter((line) => line.includes('" 206 '));
      expect(ranges.length).toBe(source.requests);
      expect(source.requests).toBeLessThan(harness.resident.size);
    } finally {
      harness.close();
    }
  });
});
