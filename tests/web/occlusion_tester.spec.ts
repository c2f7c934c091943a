/** An occlusion query that fails at any point ends, and the session continues without answers. */
import { expect, test, vi } from "vitest";
import type { StreamSession } from "../../web/stream/index.ts";
import { OcclusionTester } from "../../web/viewer/occlusion_tester.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";
import { fakeClock } from "./fake_clock.ts";

fakeClock();

const failing = (): never => {
  throw new TypeError("the driver returns nothing");
};

/** A session that requests one query, and a viewer whose renderer behaves as stated. */
function tested(view: Partial<RendererModule>): { told: string[]; tester: OcclusionTester } {
  const told: string[] = [];
  const session = {
    isClosed: false,
    occlusionQuery: () => ({ ids: new Uint32Array([7]), minPixels: 0, view: 1, picture: 1 }),
    answerOcclusion: () => told.push("answered"),
    fetchOccluded: () => told.push("failed"),
  };
  const tester = new OcclusionTester({
    guard: (action) => {
      try {
        action(view as RendererModule);
        return true;
      } catch {
        return false;
      }
    },
    isIdle: () => true,
    movesUntil: () => 0,
    isContextLost: () => false,
    answered: (settled) => told.push(settled ? "rest" : "fast"),
    ended: () => told.push("ended"),
  });
  tester.test([{ number: 0, session: session as unknown as StreamSession }], true);
  return { told, tester };
}

test("a query that cannot begin", () => {
  const { told, tester } = tested({ beginOcclusionQuery: failing });
  expect(told).toEqual(["failed", "ended"]);
  expect(tester.isRunning).toBe(false);
});

test("a query whose result cannot be read", async () => {
  let reads = 0;
  const { told, tester } = tested({
    beginOcclusionQuery: () => {},
    takeOcclusionQuery: () => (++reads < 3 ? undefined : failing()),
  });
  expect(told).toEqual([]);
  expect(tester.isRunning).toBe(true);
  await vi.advanceTimersByTimeAsync(1000);
  expect(reads).toBe(3);
  expect(told).toEqual(["failed", "ended"]);
  expect(tester.isRunning).toBe(false);
  expect(vi.getTimerCount()).toBe(0);
});

test("a query with a result", async () => {
  const answer = new Uint32Array(33);
  const { told } = tested({ beginOcclusionQuery: () => {}, takeOcclusionQuery: () => answer });
  await vi.advanceTimersByTimeAsync(1000);
  expect(told).toEqual(["answered", "rest", "ended"]);
});

test("layers that request a test take turns", async () => {
  const asked: number[] = [];
  const layer = (number: number, wants: boolean) => {
    const query = { ids: new Uint32Array([7]), minPixels: 0, view: 1, picture: 1 };
    const session = {
      occlusionQuery: () => (wants ? query : undefined),
      answerOcclusion: () => {},
    };
    return { number, session: session as unknown as StreamSession };
  };
  const renderer = {
    beginOcclusionQuery: (number: number) => void asked.push(number),
    takeOcclusionQuery: () => new Uint32Array(),
  };
  const layers = [layer(2, true), layer(3, false), layer(5, true)];
  const tester = new OcclusionTester({
    guard: (action) => {
      action(renderer as unknown as RendererModule);
      return true;
    },
    isIdle: () => true,
    movesUntil: () => 0,
    isContextLost: () => false,
    answered: () => {},
    ended: () => asked.length < 4 && tester.test(layers, true),
  });
  tester.test(layers, true);
  await vi.advanceTimersByTimeAsync(1000);
  expect(asked).toEqual([2, 5, 2, 5]);
});
