/** Commands that read a store at an address, from the project's server and through its faults. */
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer, type Server, type ServerResponse } from "node:http";
import { createServer as createSecureServer } from "node:https";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import { program, type RunningServer, serve } from "../browser/support/server.ts";
import { makeCertificate } from "../support/certificate.ts";
import { type Fault, FaultProxy, fetchedTwice } from "../support/fault_proxy.ts";
import { rangeHost } from "../support/range_host.ts";
import { type Ran, runProgram } from "../support/run_program.ts";
import { storeBytes } from "../support/store_bytes.ts";

const otherStore = "tests/golden/v1.0/u8.isosplat";

/** The file route of the server's first volume. */
async function fileOf(server: RunningServer, name: string): Promise<string> {
  const answer = await fetch(`${server.url}v1/volumes/${name}`);
  const { urls } = (await answer.json()) as { urls: { file: string } };
  return urls.file;
}

/** The only line of stderr. */
function errorOf(ran: Ran): string {
  expect(ran.code).toBe(1);
  expect(ran.stderr.trimEnd().split("\n")).toHaveLength(1);
  return ran.stderr;
}

describe.skipIf(!existsSync(program))("a store at an address", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-remote-"));
  const local = join(folder, "head.isosplat");
  let server: RunningServer;
  let proxy: FaultProxy;
  let path = "";
  let other = "";
  let address = "";

  beforeAll(async () => {
    writeFileSync(local, storeBytes());
    writeFileSync(join(folder, "other.isosplat"), readFileSync(otherStore));
    mkdirSync(join(folder, "page"));
    writeFileSync(join(folder, "page/index.html"), "<html></html>");
    server = await serve([folder], 0, ["--web-root", join(folder, "page")]);
    path = await fileOf(server, "head");
    other = await fileOf(server, "other");
  });
  beforeEach(async () => {
    proxy = new FaultProxy(server.url);
    await proxy.start();
    address = proxy.url + path;
  });
  afterEach(() => proxy.stop());
  afterAll(async () => {
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  /** The points of an isosurface, from a path or an address. */
  async function points(from: string, ...options: string[]): Promise<Buffer> {
    const output = join(folder, "points.npy");
    const ran = await runProgram([
      "extract",
      from,
      "-i",
      "100.5",
      "-o",
      output,
      "--force",
      ...options,
    ]);
    expect(ran.stderr).toBe("");
    expect(ran.code).toBe(0);
    return readFileSync(output);
  }

  test("is described as the file is", async () => {
    const expected = await runProgram(["info", local, "--json", "--chunks"]);
    const ran = await runProgram(["info", address, "--json", "--chunks"]);
    expect(ran).toEqual(expected);
    expect(ran.code).toBe(0);
  });

  test("is described from its first 64 KiB", async () => {
    expect((await runProgram(["info", address])).code).toBe(0);
    expect(proxy.requests.map(({ range }) => range)).toEqual(["bytes=0-65535"]);
  });

  test("is verified, each byte of a chunk read twice at most", async () => {
    const ran = await runProgram(["verify", address]);
    expect(ran.stderr).toContain("Verifying");
    expect(ran.stdout).toContain(": valid: ");
    expect(ran.code).toBe(0);
    const bytes = storeBytes().length;
    expect(proxy.bytesSent).toBeLessThan(2 * bytes + 65536);
  });

  test("is verified after another one through the same connection", async () => {
    const ran = await runProgram(["verify", address, proxy.url + other, "--threads", "1"]);
    expect(ran.code, ran.stderr).toBe(0);
    expect(ran.stdout.match(/: valid: /g)).toHaveLength(2);
    expect(proxy.connections).toBe(1);
  });

  test("gives the points that the file gives, with fewer requests than chunks", async () => {
    const expected = await points(local);
    proxy.requests.length = 0;
    expect((await points(address)).equals(expected)).toBe(true);
    expect(fetchedTwice(proxy.requests)).toEqual([]);
    const chunks = JSON.parse((await runProgram(["info", local, "--json", "--chunks"])).stdout) as {
      chunkReport: { levels: { blocks: number; emptyBlocks: number }[] };
    };
    const level = chunks.chunkReport.levels[0];
    const blocks = (level?.blocks ?? 0) - (level?.emptyBlocks ?? 0);
    expect(proxy.requests.length).toBeLessThan(blocks);
  });

  test("is drawn", async () => {
    const draw = async (from: string): Promise<Buffer> => {
      const picture = join(folder, "picture.png");
      const size = ["--size", "64x64", "--force"];
      const ran = await runProgram(["render", from, "-i", "100.5", "-o", picture, ...size]);
      expect(ran.code, ran.stderr).toBe(0);
      return readFileSync(picture);
    };
    expect((await draw(address)).equals(await draw(local))).toBe(true);
  });

  test("in a bundle is described, verified, extracted and drawn as in the file", async () => {
    const scenes = mkdtempSync(join(tmpdir(), "isosplat-bundle-"));
    writeFileSync(join(scenes, "head.isosplat"), storeBytes());
    writeFileSync(join(scenes, "other.isosplat"), readFileSync(otherStore));
    const document = {
      format: "isosplat-scene",
      version: 1,
      layers: [
        { name: "head", store: "head.isosplat", surfaces: [{ isovalue: 100.5 }] },
        { name: "other", store: "other.isosplat", surfaces: [{ isovalue: 100.5 }] },
      ],
    };
    writeFileSync(join(scenes, "two.scene.json"), JSON.stringify(document));
    const bundle = join(scenes, "run.isobundle");
    const made = await runProgram(["bundle", join(scenes, "two.scene.json"), "-o", bundle]);
    expect(made.code, made.stderr).toBe(0);
    const host = await rangeHost((requested) =>
      existsSync(join(scenes, requested)) ? readFileSync(join(scenes, requested)) : undefined,
    );
    try {
      const at = `${host.origin}/run.isobundle`;
      expect(await runProgram(["info", at, "--json"])).toEqual(
        await runProgram(["info", bundle, "--json"]),
      );
      const verified = await runProgram(["verify", at]);
      expect(verified.stdout).toContain(`${at}: valid: 2 layers`);
      const output = async (from: string, args: readonly string[], name: string) => {
        const ran = await runProgram([...args, from, "-o", join(folder, name), "--force"].flat());
        expect(ran.code, ran.stderr).toBe(0);
        return readFileSync(join(folder, name));
      };
      for (const [args, name] of [
        [["extract", "--mesh"], "scene.glb"],
        [["render", "--size", "64x64"], "scene.png"],
      ] as const) {
        expect((await output(at, args, name)).equals(await output(bundle, args, name))).toBe(true);
      }
      const refused = await runProgram(["info", `${host.origin}/two.scene.json`]);
      expect(refused.code).toBe(2);
      expect(refused.stderr).toContain("make a bundle of it with isosplat bundle");
    } finally {
      host.stop();
      rmSync(scenes, { recursive: true });
    }
  });

  test.each<[string, Fault]>([
    ["resets", { kind: "reset" }],
    ["status 500", { kind: "status", status: 500 }],
    ["status 503", { kind: "status", status: 503, retryAfter: 1 }],
    ["short bodies", { kind: "truncate", bytes: 1000 }],
    ["silence", { kind: "silence" }],
  ])("is read in spite of %s", async (_, fault) => {
    const expected = await points(local);
    proxy.fault = (_path, number) => (number % 2 === 1 ? fault : undefined);
    expect((await points(address, "--timeout", "1")).equals(expected)).toBe(true);
  });

  test("that stays unavailable is one error, after six attempts", async () => {
    proxy.fault = () => ({ kind: "status", status: 503 });
    const error = errorOf(await runProgram(["info", address]));
    expect(error).toContain(`${address}: reading failed: expected success, found status 503`);
    expect(error).toContain("try again later");
    expect(proxy.requests).toHaveLength(6);
  });

  test("that does not exist is one error, without another attempt", async () => {
    const error = errorOf(await runProgram(["info", `${proxy.url}/v1/none`]));
    expect(error).toContain("found status 404: check the address");
    expect(proxy.requests).toHaveLength(1);
  });

  test.each(["info", "verify"])("that is no store is one error of %s", async (command) => {
    const error = errorOf(await runProgram([command, proxy.url]));
    expect(error).toContain("expected a store or a bundle, found another file");
    expect(error).toContain("download it first");
  });

  test("that changes while it is read is one error", async () => {
    proxy.fault = (_path, number) => (number > 1 ? { kind: "elsewhere", path: other } : undefined);
    const error = errorOf(
      await runProgram(["extract", address, "-i", "100.5", "-o", join(folder, "x.ply")]),
    );
    expect(error).toContain("the object was changed while it was read");
    expect(error).toContain("run the command again");
    expect(existsSync(join(folder, "x.ply"))).toBe(false);
  });

  test("with a flipped bit is one error", async () => {
    proxy.fault = (_path, number) => (number === 2 ? { kind: "corrupt", at: -9 } : undefined);
    expect(
      errorOf(await runProgram(["verify", address]))
        .trimEnd()
        .split("\n")
        .at(-1),
    ).toMatch(/differs/);
  });

  test("is read as a whole from a server without ranges, if it is small", async () => {
    const expected = await points(local);
    proxy.fault = () => ({ kind: "whole" });
    expect((await points(address)).equals(expected)).toBe(true);
    expect(proxy.requests).toHaveLength(1);
  });

  test("is read through the environment's proxy", async () => {
    proxy.requests.length = 0;
    const ran = await runProgram(["info", `http://store.invalid${path}`], {
      http_proxy: proxy.url,
      no_proxy: undefined,
    });
    expect(ran.code).toBe(1); // the fault proxy forwards paths, not whole addresses
    expect(proxy.requests[0]?.path).toBe(`http://store.invalid${path}`);
  });

  test("is read over TLS from a server whose certificate is trusted, and no other", async () => {
    const { certificate, key } = makeCertificate(folder, "localhost");
    const more = ["--tls-cert", certificate, "--tls-key", key];
    const secure = await serve([folder], 0, ["--web-root", join(folder, "page"), ...more]);
    try {
      const url = secure.url.replace("127.0.0.1", "localhost") + path.slice(1);
      const env = { no_proxy: "localhost", NO_PROXY: "localhost" };
      const trusted = await runProgram(["info", url], { ...env, SSL_CERT_FILE: certificate });
      expect(trusted.code, trusted.stderr).toBe(0);
      const error = errorOf(await runProgram(["info", url], { ...env, SSL_CERT_FILE: undefined }));
      expect(error).toMatch(/after 1 attempt: .*certificate/);
    } finally {
      await secure.stop();
    }
  });

  test("no message has the password or the parameters of the address", async () => {
    const secret = address
      .replace("http://", "http://user:sesame@")
      .concat("?X-Amz-Signature=open#fragment");
    proxy.fault = () => ({ kind: "status", status: 403 });
    for (const given of [secret, secret.replace("http://", "HTTP://")]) {
      const error = errorOf(await runProgram(["info", given]));
      expect(error.toLowerCase()).toContain(address);
      expect(error).not.toMatch(/sesame|open|user/);
    }
  });

  test("that cannot be parsed is one error of the arguments", async () => {
    const ran = await runProgram(["info", "https://user:sesame@[:::]/a"]);
    expect(ran.code).toBe(2);
    expect(ran.stderr).toContain("expected an address");
    expect(ran.stderr).not.toContain("sesame");
  });
});

describe.skipIf(!existsSync(program))("a hostile server", () => {
  let server: Server;
  let address = "";
  let answer: (response: ServerResponse, range: string) => void = () => undefined;
  let sent = 0;

  beforeAll(async () => {
    server = createServer((request, response) => answer(response, request.headers.range ?? ""));
    await new Promise<void>((listening) => server.listen(0, "127.0.0.1", listening));
    address = `http://127.0.0.1:${(server.address() as AddressInfo).port}/a.isosplat`;
  });
  afterAll(() => server.close());

  /** Sends bytes until the connection is closed. */
  function sendForever(response: ServerResponse): void {
    sent = 0;
    const piece = Buffer.alloc(1 << 20);
    const more = (): void => {
      while (!response.destroyed && response.write(piece)) sent += piece.length;
    };
    response.on("drain", more);
    more();
  }

  test("that sends without end is left after 64 MiB", async () => {
    answer = (response) => sendForever(response.writeHead(200));
    const error = errorOf(await runProgram(["info", address]));
    expect(error).toContain("expected a server that supports byte ranges");
    expect(sent).toBeLessThan(128 << 20);
  });

  test("that sends more than the range is left", async () => {
    answer = (response) => {
      sendForever(response.writeHead(206, { "Content-Range": "bytes 0-65535/99999999999999" }));
    };
    expect(errorOf(await runProgram(["info", address]))).toContain("check the server");
    expect(sent).toBeLessThan(32 << 20); // what buffers of the system hold
  });

  test.each([
    "bytes 0-65535/*",
    "bytes 1-65536/100000",
    "bytes 0-99999999999999999999/3",
    "bytes 5-4/100000",
    "items 0-1/2",
    "",
  ])("that states the range '%s' is one error", async (range) => {
    answer = (response) => {
      response.writeHead(206, { "Content-Range": range }).end(Buffer.alloc(65536));
    };
    expect(errorOf(await runProgram(["info", address]))).toContain("check the server");
  });

  test("that claims a huge object is believed only in what arrives", async () => {
    const store = storeBytes();
    answer = (response) => {
      const headers = { "Content-Range": `bytes 0-65535/${2 ** 52}` };
      response.writeHead(206, headers).end(store.subarray(0, 65536));
    };
    expect(errorOf(await runProgram(["verify", address]))).toContain(`found ${2 ** 52}`);
  });

  test("that compresses stores is one error", async () => {
    answer = (response) => response.writeHead(200, { "Content-Encoding": "gzip" }).end("x");
    expect(errorOf(await runProgram(["info", address]))).toContain("turn off compression");
  });

  test("that redirects to a file, or in a circle, is one error", async () => {
    for (const location of ["file:///etc/passwd", "/a.isosplat"]) {
      answer = (response) => response.writeHead(302, { Location: location }).end();
      expect(errorOf(await runProgram(["info", address]))).toContain("expected a response");
    }
  });

  test("that redirects from https to http is one error", async () => {
    const folder = mkdtempSync(join(tmpdir(), "isosplat-redirect-"));
    const { certificate, key } = makeCertificate(folder, "localhost");
    const tls = { cert: readFileSync(certificate), key: readFileSync(key) };
    const secure = createSecureServer(tls, (_, response) => {
      response.writeHead(302, { Location: address }).end();
    });
    await new Promise<void>((listening) => secure.listen(0, "127.0.0.1", listening));
    answer = (response) => response.writeHead(200).end(storeBytes());
    const url = `https://localhost:${(secure.address() as AddressInfo).port}/a.isosplat`;
    const env = { SSL_CERT_FILE: certificate, no_proxy: "localhost", NO_PROXY: "localhost" };
    expect(errorOf(await runProgram(["info", url], env))).toMatch(/after 1 attempt: .*http/);
    expect((await runProgram(["info", address], env)).code).toBe(0);
    secure.close();
    rmSync(folder, { recursive: true });
  });

  test.each([404, 500])("that sends an error page without end is left: %s", async (status) => {
    let all = 0;
    answer = (response, _range) => {
      response.on("close", () => (all += sent));
      sendForever(response.writeHead(status));
    };
    expect(errorOf(await runProgram(["info", address]))).toContain(`found status ${status}`);
    expect(all).toBeLessThan(192 << 20); // of six attempts
  });

  test("an error page of any length is one short line", async () => {
    answer = (response) => response.writeHead(403).end(`<Code>${"x".repeat(1 << 20)}</Code>`);
    expect(errorOf(await runProgram(["info", address])).length).toBeLessThan(500);
  });
});
