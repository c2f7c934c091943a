// The values that slices show as black and white. tests/native/render_grey_range_test.cpp has the same table.
import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import type { StoreMetadata } from "../../web/core/types.ts";
import { greyRange } from "../../web/viewer/grey_range.ts";

const table: { what: string; range: [number, number]; metadata: StoreMetadata; greys: number[] }[] =
  JSON.parse(readFileSync(new URL("../support/grey_ranges.json", import.meta.url), "utf8"));

for (const { what, range, metadata, greys } of table) {
  test(what, () => expect(greyRange({ range, metadata })).toEqual(greys));
}
