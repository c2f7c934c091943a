import { expect, it } from "vitest";
import type { Chunk } from "../../web/core/index.ts";
import { Prefetch } from "../../web/stream/prefetch.ts";

const chunks = [0, 1, 2, 3, 4].map((handle) => ({ handle }) as Chunk);
const [a, b, c, d, e] = chunks as [Chunk, Chunk, Chunk, Chunk, Chunk];

it("keeps what is prefetched until the movement is over", () => {
  const prefetch = new Prefetch();
  // Nothing is requested for a view that changes at once, but requests in flight are finished.
  expect(prefetch.select([a, b], [b, c], [d])).toEqual([b, d]);
  // The next frames do not need it, and prefetch nothing.
  expect(prefetch.select([a], [b, d], [])).toEqual([d]);
  expect(prefetch.select([], [d], [e])).toEqual([d, e]);
  prefetch.end();
  expect(prefetch.select([e], [d, e], [])).toEqual([e]);
});

it("requests no chunk again that has arrived", () => {
  const prefetch = new Prefetch();
  expect(prefetch.select([], [], [a, b])).toEqual([a, b]);
  expect(prefetch.select([a], [b], [])).toEqual([b]);
});
