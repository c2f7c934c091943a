/** Which picture is tested, and with which threshold, until a view is complete. */
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

/** Asks of the present picture, and answers; `fast` or at rest. Returns the threshold. */
function answered(queries: OcclusionQueries, settled: boolean): number | undefined {
  const query = queries.query(settled);
  if (query) queries.record(query, settled);
  return query?.minPixels;
}

test("fast pictures tell what to fetch; one picture at rest tells that it is everything", () => {
  const queries = new OcclusionQueries();
  queries.need({ ...nothing, isUndecided: true });
  expect(answered(queries, false)).toBe(255);
  queries.need(loading);
  expect(queries.query(false)).toBeUndefined();
  // A picture of some of the chunks: more may be visible in it.
  queries.pictureChanged();
  expect(answered(queries, false)).toBe(255);
  queries.pictureChanged();
  queries.need(nothing);
  expect(queries.needsRest).toBe(false);
  expect(answered(queries, false)).toBe(0);
  // The next picture is that at rest: another fast one would find less than it.
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
  // Another view begins anew.
  queries.viewChanged();
  queries.need({ ...nothing, isUndecided: true });
  expect(queries.done).toBe(false);
  expect(answered(queries, false)).toBe(255);
});

test("what the last picture at rest finds is tested again at rest", () => {
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

test("coarse levels on their way are waited for", () => {
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
