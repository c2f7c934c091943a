// The look of a scene that is saved.
import { expect, test } from "vitest";
import { lookDocument } from "../../web/scene/look_document.ts";
import { defaultLook, type Look } from "../../web/viewer/types.ts";

const field = { name: "p", range: [1, 2], scale: "linear", steps: 5, lines: 0.5 } as const;
const look = (change: Partial<Look["field"]>, colourBy: Look["colourBy"] = "field"): Look => ({
  ...defaultLook,
  colourBy,
  field: { ...field, ...change },
});
const written = (change: Partial<Look["field"]>, before?: unknown) =>
  JSON.parse(JSON.stringify(lookDocument(look(change), before)));

test("a field is written as it is shown", () => {
  expect(written({})).toMatchObject({ colour_by: "field", field });
  expect(written({ range: null }).field).toEqual({
    name: "p",
    scale: "linear",
    steps: 5,
    lines: 0.5,
  });
  expect(written({ scale: "logarithmic", range: [0, 2] }).field.range).toEqual([0.002, 2]);
});

test("what scenes cannot have is not written", () => {
  expect(written({ range: [7, 7] }).field).not.toHaveProperty("range");
  expect(written({ range: [2, 1] }).field).not.toHaveProperty("range");
  expect([1, 2.5, 257].map((steps) => written({ steps }).field.steps)).toEqual([0, 0, 0]);
  for (const lines of [0, -1, Number.NaN, Number.POSITIVE_INFINITY]) {
    expect(written({ lines }).field).not.toHaveProperty("lines");
  }
  const unnamed = written({ name: "é".repeat(33) });
  expect(unnamed.colour_by).toBe("isosurface");
  expect(unnamed).not.toHaveProperty("field");
});

test("a field of the scene stays while colours do not show it, with its unknown members", () => {
  const before = { field: { name: "p", unit: "Pa" }, more: 1 };
  const hidden = lookDocument(look({}, "isosurface"), before);
  expect(hidden).toMatchObject({
    colour_by: "isosurface",
    more: 1,
    field: { ...field, unit: "Pa" },
  });
  expect(written({ name: "q" }, before).field).not.toHaveProperty("unit");
  expect(lookDocument(defaultLook, undefined)).toBeUndefined();
});
