/** A scripted session with the real page and server: checks the requests and their sizes. */
import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { existsSync, statSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { expect, test } from "@playwright/test";
import { Visitor } from "../bench/stream/visit.ts";
import { chunksOf } from "./support/chunks.ts";
import { dragOverRange, saveData, slideTo } from "./support/in_page.ts";
import { settled } from "./support/view.ts";

const built = (path: string): string =>
  fileURLToPath(new URL(`../../build/${path}`, import.meta.url));
const store = built("release/tests/shared/fixture.isosplat");

let server: ChildProcess;
let url: string;

test.beforeAll(async () => {
  if (!existsSync(store)) throw new Error(`${store} is missing: npm run build -- release`);
  server = spawn(
    built("release/native/cli/isosplat"),
    ["serve", store, "--port", "0", "--web-root", built("page")],
    { stdio: ["ignore", "pipe", "ignore"] },
  );
  let text = "";
  while (!/http:\/\/\S+/.test(text)) {
    const output = server.stdout;
    if (!output) throw new Error("the server has no output");
    text += String((await once(output, "data"))[0]);
  }
  url = /http:\/\/[^\s/]+\//.exec(text)?.[0] ?? "";
});

test.afterAll(async () => {
  const ended = once(server, "exit");
  server.kill("SIGTERM");
  await ended;
});

/** Waits for the browser's network events, which may arrive later than the page's events. */
async function expectCounted(visitor: Visitor, payloadBytes: number): Promise<void> {
  await expect.poll(() => visitor.data.bytes).toBeGreaterThan(payloadBytes);
}

test("a session fetches few bytes, in few requests, and nothing twice", async ({ browser }) => {
  const visitor = await Visitor.arrive(browser);
  const { page } = visitor;
  const problems: string[] = [];
  page.on("pageerror", (error) => problems.push(String(error)));
  await page.goto(`${url}?volume=fixture&isovalue=100.5`);

  await visitor.mark("isosplat:surface");
  const first = await visitor.markDetail("isosplat:surface");
  expect(first.requests).toBeLessThanOrEqual(6);
  expect(first.bytesReceived).toBeLessThanOrEqual(150_000);

  await visitor.mark("isosplat:complete");
  const complete = await visitor.markDetail("isosplat:complete");
  expect(complete.bytesReceived).toBeLessThan(0.35 * statSync(store).size);
  expect(complete.requests).toBeLessThanOrEqual(16);

  // Coarse levels for other isovalues follow.
  await visitor.mark("isosplat:prepared");
  const prepared = await visitor.markDetail("isosplat:prepared");
  expect(prepared.bytesReceived - complete.bytesReceived).toBeGreaterThan(10_000);
  expect(prepared.bytesReceived - complete.bytesReceived).toBeLessThan(
    0.3 * statSync(store).size + 10_000,
  );

  // Then the rest of the store, because it is small.
  await visitor.mark("isosplat:kept");
  const kept = await visitor.markDetail("isosplat:kept");
  expect(kept.bytesReceived).toBeGreaterThan(0.95 * statSync(store).size);
  expect(kept.bytesReceived).toBeLessThan(1.05 * statSync(store).size + 10_000);
  await expectCounted(visitor, kept.bytesReceived);
  expect(visitor.data.bytes).toBeLessThan(kept.bytesReceived * 1.1 + 10_000);

  // No isovalue makes a request any more.
  const before = visitor.urls.length;
  await page.evaluate(slideTo, 101.5);
  await settled(page);
  await page.evaluate(dragOverRange, 3);
  await settled(page);
  expect(visitor.urls.slice(before)).toEqual([]);

  const fetched = chunksOf(visitor.urls);
  expect(fetched.length).toBeGreaterThan(0);
  expect(new Set(fetched).size).toBe(fetched.length);
  expect(problems).toEqual([]);
  await visitor.leave();
});

test("a reload is served by the browser's cache", async ({ browser }) => {
  const visitor = await Visitor.arrive(browser);
  // Otherwise a complete view fetches other isovalues, and requests differ by time.
  await visitor.page.addInitScript(saveData);
  const address = `${url}?volume=fixture&isovalue=100.5`;
  await visitor.page.goto(address);
  await visitor.mark("isosplat:complete");
  await expectCounted(visitor, (await visitor.markDetail("isosplat:complete")).bytesReceived);
  const before = { ...visitor.data };
  await visitor.page.goto("about:blank");
  await visitor.page.goto(address);
  await visitor.mark("isosplat:complete");
  // The page revalidates the volume's name; its content is cached.
  expect(visitor.data.requests - before.requests).toBeLessThanOrEqual(2);
  expect(visitor.data.bytes - before.bytes).toBeLessThan(10_000);
  await visitor.leave();
});

test("with the data saver on, a drag over the range makes few requests", async ({ browser }) => {
  const visitor = await Visitor.arrive(browser);
  const { page } = visitor;
  await page.addInitScript(saveData);
  await page.goto(`${url}?volume=fixture&isovalue=100.5`);
  await visitor.mark("isosplat:complete");
  const before = visitor.urls.length;
  const seconds = await page.evaluate(dragOverRange, 3);
  expect(visitor.urls.length - before).toBeLessThanOrEqual(10 * Math.ceil(seconds));
  const fetched = chunksOf(visitor.urls);
  expect(new Set(fetched).size).toBe(fetched.length);
  await visitor.leave();
});

test("offline, then online: the coarse surface stays, and is refined", async ({ browser }) => {
  const visitor = await Visitor.arrive(browser);
  const { page } = visitor;
  await page.addInitScript(saveData);
  await page.goto(`${url}?volume=fixture&isovalue=100.5`);
  await visitor.mark("isosplat:complete");
  await page.context().setOffline(true);
  await page.evaluate(slideTo, 400.5);
  await expect(page.locator(".status")).toHaveAttribute("data-state", "offline");
  await page.context().setOffline(false);
  await visitor.mark("isosplat:complete", 2);
  await visitor.leave();
});
