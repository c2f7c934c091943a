// The credentials that a source sends to its host: header fields, and the query of a signed link.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { afterAll, beforeAll, describe, expect, it } from "vitest";
import {
  FileSource,
  ServerSource,
  type Source,
  type SourceOptions,
  StreamError,
} from "../../web/stream/index.ts";
import { withQuery } from "../../web/stream/transfer.ts";
import { program, type RunningServer, serve } from "../browser/support/server.ts";
import { core as load, storeBytes } from "./fixture.ts";
import { Harness, view } from "./stream_harness.ts";

const token = "token-0123456789abcdef";
const folder = mkdtempSync(join(tmpdir(), "isosplat-admittance-"));
const keyFile = join(folder, "key");
let server: RunningServer;
let file = "";
let link = "";

beforeAll(async () => {
  writeFileSync(join(folder, "test.isosplat"), storeBytes());
  writeFileSync(join(folder, "tokens"), `${token} test\n`);
  writeFileSync(keyFile, "k".repeat(64));
  server = await serve([folder], 0, [
    ...["--token-file", join(folder, "tokens")],
    ...["--link-key-file", keyFile],
  ]);
  const headers = { Authorization: `Bearer ${token}` };
  const answer = await fetch(`${server.url}v1/volumes/test`, { headers });
  const { urls } = (await answer.json()) as { urls: { file: string } };
  file = new URL(urls.file, server.url).href;
  const signed = execFileSync(program, ["sign-link", "test", "--link-key-file", keyFile]);
  const { searchParams } = new URL(signed.toString().trim());
  searchParams.delete("volume");
  link = searchParams.toString();
});
afterAll(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

const sources: [string, (options: SourceOptions) => Source][] = [
  ["ServerSource", (o) => new ServerSource({ base: server.url, volume: "test", ...o })],
  // Any host that answers Range requests and requires the same credentials.
  ["FileSource", (options) => new FileSource(file, options)],
];

describe.each(sources)("%s", (_, make) => {
  it.each([
    ["header fields", () => ({ headers: { Authorization: `Bearer ${token}` } })],
    ["a signed link", () => ({ query: link })],
  ])("streams with %s", async (_way, options) => {
    const harness = new Harness();
    await harness.open(make(options()), await load(), { firstIsovalues: [100.5] });
    try {
      harness.session?.update(view(100.5));
      await harness.complete();
      expect(harness.errors).toEqual([]);
      expect(harness.progress?.finestLevel).toBe(0);
    } finally {
      harness.close();
    }
  });

  it.each([
    ["nothing", () => ({})],
    ["a wrong token", () => ({ headers: { Authorization: "Bearer wrong-0123456789" } })],
    ["a changed link", () => ({ query: link.replace("exp=", "exp=9") })],
  ])("is refused with %s", async (_way, options) => {
    const refused = await make(options())
      .header(AbortSignal.timeout(20_000))
      .catch((e) => e);
    expect(refused).toBeInstanceOf(StreamError);
    expect((refused as StreamError).kind).toBe("access-denied");
  });
});

it("the server reads tokens again on SIGHUP, and continues", async () => {
  const tokens = join(folder, "tokens");
  const other = "other-0123456789abcdef";
  const status = async (of: string): Promise<number> => {
    const headers = { Authorization: `Bearer ${of}` };
    return (await fetch(`${server.url}v1/volumes/test`, { headers })).status;
  };
  expect([await status(token), await status(other)]).toEqual([200, 401]);
  writeFileSync(tokens, `${other} test\n`);
  server.signal("SIGHUP");
  await expect.poll(() => status(other), { timeout: 60_000 }).toBe(200);
  expect(await status(token)).toBe(401);
  writeFileSync(tokens, `${token} test\n`);
  server.signal("SIGHUP");
  await expect.poll(() => status(token), { timeout: 60_000 }).toBe(200);
});

it("a presigned URL is requested unchanged", () => {
  expect(withQuery("https://b.example/s?X-Signature=a%2Fb", undefined)).toBe(
    "https://b.example/s?X-Signature=a%2Fb",
  );
  expect(withQuery("https://b.example/s?a=1", "b=2")).toBe("https://b.example/s?a=1&b=2");
  expect(withQuery("https://b.example/s", "b=2")).toBe("https://b.example/s?b=2");
});
