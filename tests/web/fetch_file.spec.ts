/**
 * Files of volumes from real hosts: broken connections, refusals, and files that are known already.
 */
import { mkdtempSync, rmSync, utimesSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, test } from "vitest";
import { type FetchOptions, fetchFile } from "../../web/device/fetch_file.ts";
import { RemoteFiles } from "../../web/device/remote_files.ts";
import { type Fault, FaultProxy } from "../support/fault_proxy.ts";
import { hasNginx, type Nginx, nginx } from "../support/nginx.ts";

const bytes = Uint8Array.from({ length: 100_000 }, (_, i) => (i * i) >> 3);
const neverEnds = new AbortController().signal;

function get(address: string, options: Partial<FetchOptions> = {}) {
  return fetchFile(new URL(address), { signal: neverEnds, progress: () => {}, ...options });
}

async function contentOf(file: File | undefined): Promise<Uint8Array> {
  return new Uint8Array((await file?.arrayBuffer()) ?? []);
}

describe.skipIf(!hasNginx)("a file on nginx", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-fetch-"));
  const path = join(folder, "head one.raw");
  let host: Nginx;
  let proxy: FaultProxy;
  /** The faults of the requests, in order. */
  let faults: (Fault | undefined)[];
  const ranges = () => proxy.requests.map(({ range }) => range);
  const address = () => `${proxy.url}/head%20one.raw`;

  beforeAll(async () => {
    writeFileSync(join(folder, "page.html"), "<!doctype html><title>Files</title>");
    host = await nginx({ folders: [folder] });
  });
  afterAll(async () => {
    await host?.stop();
    rmSync(folder, { recursive: true, force: true });
  });
  beforeEach(async () => {
    writeFileSync(path, bytes);
    utimesSync(path, 1000, 1000);
    faults = [];
    proxy = new FaultProxy(host.url);
    proxy.fault = (_, number) => faults[number - 1];
    await proxy.start();
  });
  afterEach(() => proxy.stop());

  test("is fetched with progress, its name and its time", async () => {
    const steps: [number, number | undefined][] = [];
    const { file } = await get(address(), {
      progress: (received, whole) => steps.push([received, whole]),
    });
    expect(file?.name).toBe("head one.raw");
    expect(file?.lastModified).toBe(1_000_000);
    expect(await contentOf(file)).toEqual(bytes);
    expect(steps.at(-1)).toEqual([bytes.length, bytes.length]);
  });

  test("continues where the connection broke", async () => {
    faults = [{ kind: "truncate", bytes: 30_000 }];
    expect(await contentOf((await get(address())).file)).toEqual(bytes);
    expect(ranges()).toEqual([undefined, "bytes=30000-99999"]);
  });

  test("begins again if the host does not send parts", async () => {
    faults = [{ kind: "truncate", bytes: 30_000 }, { kind: "whole" }];
    expect(await contentOf((await get(address())).file)).toEqual(bytes);
    expect(ranges()).toEqual([undefined, "bytes=30000-99999", undefined]);
  });

  test("begins again if the host does not state the file's version", async () => {
    const cut = { kind: "truncate", bytes: 30_000 } as const;
    const plain = createServer((_request, response) => {
      response.writeHead(200, { "Content-Length": bytes.length });
      if (faults.shift()) response.write(bytes.subarray(0, cut.bytes), () => response.destroy());
      else response.end(bytes);
    });
    await new Promise<void>((resolve) => plain.listen(0, "127.0.0.1", resolve));
    faults = [cut];
    const { file, version } = await get(
      `http://127.0.0.1:${(plain.address() as AddressInfo).port}/a.raw`,
    );
    expect(await contentOf(file)).toEqual(bytes);
    expect(version).toBeUndefined();
    plain.closeAllConnections();
    plain.close();
  });

  test("a file that was replaced in the meantime is not joined with the new one", async () => {
    faults = [{ kind: "truncate", bytes: 30_000 }];
    const fault = proxy.fault;
    proxy.fault = (requested, number, method) => {
      if (number === 2) {
        writeFileSync(path, bytes.slice().reverse());
        utimesSync(path, 2000, 2000);
      }
      return fault(requested, number, method);
    };
    await expect(get(address())).rejects.toThrow("replaced while it was fetched: open it again");
  });

  test("a known file is not fetched", async () => {
    const { version } = await get(address());
    expect(version).toContain("GMT");
    const again = await get(address(), { isKnown: (found) => found === version });
    expect(again).toEqual({ file: undefined, version });
  });

  test("a file that is too large is refused by its length, before it arrives", async () => {
    let received = 0;
    const progress = (now: number) => {
      received = now;
    };
    await expect(get(address(), { maxBytes: 99_999, progress })).rejects.toThrow(
      "head one.raw: expected at most 0.0 GB, found 0.0 GB: download it, and build its store with " +
        "the program: isosplat build head one.raw",
    );
    expect(received).toBe(0);
  });

  test("reports a missing file, a refusal, a fault of the host and a page in one sentence each", async () => {
    await expect(get(`${proxy.url}/none.raw`)).rejects.toThrow(/404.*check the address\.$/);
    for (const [status, words] of [
      [403, "open the complete link"],
      [500, "open it again later"],
    ] as const) {
      proxy.fault = () => ({ kind: "status", status });
      await expect(get(address())).rejects.toThrow(words);
    }
    proxy.fault = () => ({ kind: "elsewhere", path: "/page.html" });
    await expect(get(address())).rejects.toThrow(
      "expected a volume's file, found a web page (text/html)",
    );
    await proxy.stop();
    await expect(get(address())).rejects.toThrow("check the address and your connection");
    await proxy.start();
  });

  test("cancelling ends the wait for a host that does not respond", async () => {
    proxy.fault = () => ({ kind: "silence" });
    const ending = new AbortController();
    const fetched = get(address(), { signal: ending.signal });
    await expect.poll(() => proxy.requests.length).toBe(1);
    ending.abort(new Error("enough"));
    await expect(fetched).rejects.toThrow("enough");
  });

  test("files that a header names are fetched relative to it, from the same host", async () => {
    const remote = new RemoteFiles(new URL(`${proxy.url}/scans/one/head.nhdr?key=1`), {
      signal: neverEnds,
      progress: () => {},
    });
    const found = await remote.find("head one.raw");
    expect(found?.path).toBe("head one.raw");
    expect(await contentOf(found?.file)).toEqual(bytes);
    expect(await remote.find("http:/elsewhere.example/a.raw")).toBeUndefined();
    expect(proxy.requests.map((request) => request.path)).toEqual([
      "/head%20one.raw?key=1",
      "/http%3A/elsewhere.example/a.raw?key=1",
    ]);
  });
});
