/** The simulation of many viewers: its calculations, and a replay through nginx and the real server. */
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, describe, expect, it } from "vitest";
import { type RunningServer, serve } from "../browser/support/server.ts";
import { Account, quantile } from "../evidence/viewers/account.ts";
import { audience, zipf } from "../evidence/viewers/audience.ts";
import { inOrder, itemsOf, LruCache, newShares, simulate } from "../evidence/viewers/lru.ts";
import { OriginMeter, servedByRoute, sum } from "../evidence/viewers/origin.ts";
import { pageRequests, withPage } from "../evidence/viewers/page_requests.ts";
import { record } from "../evidence/viewers/record.ts";
import { addressOf, replay } from "../evidence/viewers/replay.ts";
import type { RecordedVisit } from "../evidence/viewers/requests.ts";
import {
  hasPackagedNginx,
  type PackagedNginx,
  startPackagedNginx,
} from "../support/packaged_nginx.ts";

const content = "/v1/volumes/a/0123456789abcdef0123456789abcdef";
const visitOf = (volume: string, ...paths: string[]): RecordedVisit => ({
  volume,
  scenario: "look",
  requests: paths.map((path, i) => ({ at: 10 * i, path, bytes: 100 })),
  duration: 1000,
});
const a = visitOf("a", "/v1/volumes/a/bootstrap", `${content}/chunks/1`, `${content}/chunks/2`);
const b = visitOf("b", "/v1/volumes/b/bootstrap", `${content}/chunks/2`, `${content}/chunks/3`);

describe("arrivals of viewers", () => {
  const options = { viewers: 4000, minutes: 10, visits: [[a], [b]], exponent: 0.8, seed: 7 };
  const plan = audience(options);
  const gaps = plan.map(({ at }, i) => at - (plan[i - 1]?.at ?? 0));

  it("are the same for the same seed", () => {
    expect(audience(options)).toEqual(plan);
    expect(audience({ ...options, seed: 8 })).not.toEqual(plan);
  });

  it("are those of a Poisson process", () => {
    expect(plan.length).toBe(4000);
    expect(Math.min(...gaps)).toBeGreaterThanOrEqual(0);
    const mean = gaps.reduce((sum, gap) => sum + gap, 0) / gaps.length;
    // Four standard errors.
    expect(Math.abs(mean - 150)).toBeLessThan((4 * 150) / Math.sqrt(4000));
    // Of exponential times, 1/e are longer than their mean.
    const longer = gaps.filter((gap) => gap > 150).length / gaps.length;
    expect(Math.abs(longer - Math.exp(-1))).toBeLessThan(0.03);
  });

  it("come to volumes by Zipf's law", () => {
    expect(zipf(3, 1).map((share) => Math.round(1100 * share))).toEqual([600, 300, 200]);
    const [first = 0] = zipf(2, 0.8);
    const share = plan.filter(({ visit }) => visit === a).length / plan.length;
    expect(Math.abs(share - first)).toBeLessThan(0.03);
  });

  it("need a recorded visit of each volume", () => {
    expect(() => audience({ ...options, visits: [[a], []] })).toThrow("of each volume");
  });

  it("come from separate addresses", () => {
    const addresses = Array.from({ length: 70_000 }, (_, i) => addressOf(i));
    expect(new Set(addresses).size).toBe(70_000);
    expect(addresses[69_999]).toBe("127.2.17.111");
  });
});

describe("calculated caches", () => {
  const plan = [
    { at: 5, visit: b },
    { at: 0, visit: a },
  ];

  it("get requests in the order of their times", () => {
    expect(inOrder(plan).map(({ path }) => path.replace(/.*\/(?=.)/, ""))).toEqual([
      ...["bootstrap", "bootstrap", "1", "2", "2", "3"],
    ]);
  });

  it("keep content that never changes, and fetch it once", () => {
    expect(simulate(inOrder(plan), Infinity)).toEqual({
      ...{ requests: 6, bytes: 600, hits: 1, hitBytes: 100 },
      ...{ fetchedBytes: 500, entries: 3, cacheBytes: 300 },
    });
  });

  it("drop the least recently used content", () => {
    const cache = new LruCache(30);
    const uses = ["x", "y", "x", "z", "x", "y"].map((key) => cache.use(key, 15));
    expect(uses).toEqual([false, false, true, false, true, false]);
    expect(cache.bytes).toBe(30);
    expect(cache.use("large", 31)).toBe(false);
    expect([cache.bytes, cache.entries]).toEqual([0, 0]);
  });

  it("have entries for encodings and for pieces of files, and none for changing content", () => {
    const request = { at: 0, bytes: 5 };
    expect(itemsOf({ ...request, path: "/" })).toEqual([]);
    expect(itemsOf({ ...request, path: `${content}/thumbnail.webp` })).toEqual([]);
    expect(itemsOf({ ...request, path: "/assets/a.js", encoding: "br" })).toEqual([
      { key: "/assets/a.js br", bytes: 5 },
    ]);
    const range = { ...request, path: `${content}/file`, range: "bytes=1048570-1048580" };
    expect(itemsOf(range).map(({ key }) => key)).toEqual([
      `${content}/file 0`,
      `${content}/file 1`,
    ]);
  });

  it("state the share of a visit that no other visit has", () => {
    expect(newShares([a, b])).toEqual([0.5, 0.5]);
    expect(newShares([a, a, b])).toEqual([0, 0, 0.5]);
  });
});

describe("counts of a replay", () => {
  const answer = { status: 200, cache: "HIT", bytes: 10, latency: 1, late: 0, isCancelled: false };

  it("have one outcome for each request", () => {
    const account = new Account();
    account.add(answer);
    account.add({ ...answer, status: 206, cache: "MISS", latency: 3 });
    account.add({ ...answer, cache: "EXPIRED" });
    account.add({ ...answer, cache: undefined });
    account.add({ ...answer, status: 429, cache: undefined });
    account.add({ ...answer, status: 502 });
    account.add({ ...answer, status: undefined, fault: "reset" });
    account.add({ ...answer, status: undefined, isCancelled: true });
    const { hits, misses, passed, refused, failed, cancelled } = account;
    expect({ hits, misses, passed, refused, failed, cancelled }).toEqual({
      ...{ hits: 1, misses: 2, passed: 1, refused: 1, failed: 2, cancelled: 1 },
    });
    expect([...account.faults]).toEqual([
      ["502", 1],
      ["reset", 1],
    ]);
    expect([account.requests, account.bytes, account.hitBytes]).toEqual([8, 80, 10]);
    expect([account.latency(0.5), account.latency(1)]).toEqual([1, 3]);
  });

  it("have quantiles by the nearest rank", () => {
    expect([0, 0.5, 0.51, 1].map((share) => quantile([4, 1, 3, 2], share))).toEqual([1, 2, 3, 4]);
  });

  it("of the server are read by route", () => {
    const text = `isosplat_http_requests_total{route="/a",status="200"} 3
isosplat_http_requests_total{route="/a",status="304"} 1
isosplat_http_response_body_bytes_total{route="/a"} 70
isosplat_http_request_duration_seconds_count{route="/a"} 4
isosplat_http_requests_total{route="/b",status="200"} 2
`;
    const routes = servedByRoute(text);
    expect(routes.get("/a")).toEqual({ requests: 4, bytes: 70 });
    expect(sum(routes)).toEqual({ requests: 6, bytes: 70 });
  });
});

describe("requests of the page", () => {
  const line = (end: string, target: string) => ({
    ...{ end, seconds: "0.500", target, range: "", encoding: "br", bytes: "7" },
  });

  it("come before and beside those of its client", () => {
    const page = pageRequests([
      line("100.600", "/assets/a.js"),
      line("101.700", "/v1/volumes/a/bootstrap"),
      line("100.500", "/"),
      line("102.000", `${content}/chunks/0/0.0.0/1`),
    ]);
    expect(page.requests.map(({ path }) => path)).toEqual(["/", "/assets/a.js"]);
    expect(page.requests[1]).toEqual({
      ...{ at: expect.closeTo(100, 1), path: "/assets/a.js", encoding: "br", bytes: 7 },
    });
    const whole = withPage(a, page);
    expect(whole.requests.map(({ at }) => Math.round(at))).toEqual([0, 100, 1200, 1210, 1220]);
  });
});

describe.skipIf(!hasPackagedNginx)("a recorded visit", () => {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-viewers-"));
  const root = fileURLToPath(new URL("../..", import.meta.url));
  let server: RunningServer;
  /** One proxy for the recording, and one with an empty cache for the replay. */
  const proxies: PackagedNginx[] = [];

  beforeAll(async () => {
    // biome-ignore format: options with their values
    server = await serve([join(root, "build/release/tests/shared/fixture.isosplat")], 0, [
      "--allow-host", "volumes.example", "--trusted-proxy", "127.0.0.1",
    ]);
    for (const name of ["first", "second"]) {
      mkdirSync(join(folder, name));
      proxies.push(await startPackagedNginx(join(folder, name), new URL(server.url).port));
    }
  }, 60_000);

  afterAll(async () => {
    for (const proxy of proxies) await proxy.stop();
    await server?.stop();
    rmSync(folder, { recursive: true, force: true });
  });

  it("is replayed: each miss reaches the server, and each request is counted once", async () => {
    const [first, second] = proxies;
    if (!first || !second) throw new Error("no proxy");
    const wanted = [{ volume: "fixture", scenario: "look", seed: 1 }];
    const options = { together: 1, roundTripMs: 2, megabitsPerSecond: 100, isMultiplexed: true };
    const [visit] = await record(first, wanted, options);
    const asked =
      visit?.requests.filter(({ cancelledAfter }) => cancelledAfter === undefined) ?? [];
    const paths = asked.map(({ path }) => path);
    expect(paths[0]).toBe("/v1/volumes/fixture/bootstrap");
    expect(paths.filter((path) => path.includes("/chunks/")).length).toBeGreaterThan(3);
    expect(paths.filter((path) => path.includes("/batch"))).toEqual([]);

    // Replay without pauses. The requests are the same.
    const requests = asked.map((request) => ({ ...request, at: 0 }));
    const quick = { volume: "fixture", scenario: "look", requests, duration: 0 };
    const viewers = 20;
    const plan = Array.from({ length: viewers }, (_, i) => ({ at: 10 * i, visit: quick }));
    const account = new Account();
    const meter = await OriginMeter.start(server.url);
    await replay(second, plan, account);
    await meter.stop();

    expect(account.requests).toBe(viewers * paths.length);
    expect(account.failed + account.refused).toBe(0);
    expect(account.passed).toBe(viewers);
    expect(account.misses).toBe(new Set(paths).size - 1);
    // A range of the file may need two of the pieces in which nginx fetches it.
    const pieces = new Set(asked.flatMap(itemsOf).map(({ key }) => key)).size;
    expect(sum(meter.byRoute).requests).toBe(pieces + viewers);
    const bytes = requests.reduce((all, request) => all + request.bytes, 0);
    expect(account.bytes).toBe(viewers * bytes);
  });
});
