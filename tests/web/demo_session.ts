/** A demo volume on the real server behind a proxy, and a harness for its sessions; new for each test. */
import { existsSync } from "node:fs";
import { join } from "node:path";
import { afterAll, afterEach, beforeAll, beforeEach, vi } from "vitest";
import type { Core } from "../../web/core/index.ts";
import { demoFolder, type RunningServer, serve } from "../browser/support/server.ts";
import { FaultProxy } from "../support/fault_proxy.ts";
import { clockThatJumps } from "./fake_clock.ts";
import { core as load } from "./fixture.ts";
import { Harness } from "./stream_harness.ts";

export const store = join(demoFolder, "mandelbulb.isosplat");

export let core: Core;
export let server: FaultProxy;
export let harness: Harness;

/** Another visitor: tests end the sessions of the present harness first. */
export function newHarness(): void {
  harness = new Harness();
}

/** The requests for chunks that the proxy has seen. */
export const chunkRequests = () => server.requests.filter(({ path }) => /batch|chunks/.test(path));

/** Sets all of this up for the tests of the present file, with a clock that jumps. */
export function serveDemo(): void {
  let isosplat: RunningServer;
  clockThatJumps();
  beforeAll(async () => {
    if (!existsSync(store)) throw new Error(`${store} is missing: .ci/build demo`);
    core = await load();
    isosplat = await serve([store]);
  });
  afterAll(async () => {
    await isosplat?.stop();
  });
  beforeEach(async () => {
    server = new FaultProxy(isosplat.url);
    await server.start();
    newHarness();
  });
  afterEach(async () => {
    vi.unstubAllGlobals();
    harness.close();
    await server.stop();
  });
}
