/** The pictures that are tested, and their thresholds, until a view is complete. */
import { expect, test } from "vitest";
import { type OcclusionNeeds, OcclusionQueries } from "../../web/stream/occlusion_queries.ts";

const ids = new Uint32Array([7]);
const nothing: OcclusionNeeds = {
  ids,
  isLoading: false,
  isUndecided: false,
  isTooCoarse: false,
};
const loading: OcclusionNeeds = { ...nothing, isLoading: true };

/**
 * Runs the query that the present picture needs, and records its result. `settled`: the picture is
 * at rest. Returns the threshold.
 */
function answered(queries: OcclusionQueries, settled: boolean): number | undefined {
  const query = queries.query(settled);
  if (query) queries.record(query, settled);
  return query?.minPixels;
}

test("fast pictures find the chunks to fetch; one picture at rest confirms that none is missing", () => {
  const queries = new OcclusionQueries();
  queries.need({ ...nothing, isUndecided: true });
  expect(answered(queries, false)).toBe(255);
  queries.need(loading);
  expect(queries.query(false)).toBeUndefined();
  // A picture with some of the chunks. More regions may be visible in it.
  queries.pictureChanged();
  expect(answered(queries, false)).toBe(255);
  queries.pictureChanged();
  queries.need(nothing);
  expect(queries.needsRest).toBe(false);
  expect(answered(queries, false)).toBe(0);
  // The next picture is the resting one, because another fast picture would find less.
  queries.need(loading);
  queries.pictureChanged();
  expect(queries.query(false)).toBeUndefined();
  expect(queries.query(true)).toBeUndefined();
  queries.need(nothing);
  expect(queries.needsRest).toBe(true);
  expect(queries.query(false)).toBeUndefined();
  expect(queries.done).toBe(false);
  expect(answered(queries, true)).toBe(0);
  queries.need(nothing);
  expect(queries.done).toBe(true);
  expect(queries.needsRest).toBe(false);
  // Another view begins with the first step again.
  queries.viewChanged();
  queries.need({ ...nothing, isUndecided: true });
  expect(queries.done).toBe(false);
  expect(answered(queries, false)).toBe(255);
});

test("after the last picture at rest has found chunks, another one at rest is tested", () => {
  const queries = new OcclusionQueries();
  for (let step = 0; step < 2; ++step) {
    queries.need(nothing);
    answered(queries, true);
  }
  queries.need(loading);
  expect(queries.done).toBe(false);
  queries.pictureChanged();
  queries.need(nothing);
  expect(queries.done).toBe(false);
  expect(answered(queries, true)).toBe(0);
  queries.need(nothing);
  expect(queries.done).toBe(true);
});

test("queries wait for coarse levels that are being fetched", () => {
  const queries = new OcclusionQueries();
  queries.need({ ...nothing, isUndecided: true, isTooCoarse: true });
  expect(queries.query(false)).toBeUndefined();
  expect(queries.done).toBe(false);
  queries.need({ ...nothing, isUndecided: true });
  expect(answered(queries, false)).toBe(255);
});

test("an answer for an earlier view is not valid", () => {
  const queries = new OcclusionQueries();
  queries.need(nothing);
  const query = queries.query(true);
  if (!query) throw new Error("no query");
  queries.viewChanged();
  expect(queries.record(query, true)).toBe(false);
  queries.need(nothing);
  expect(queries.done).toBe(false);
  expect(answered(queries, true)).toBe(255);
});
