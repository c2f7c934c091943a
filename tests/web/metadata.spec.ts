// Reads the metadata of stores that were written by other programs.
import { expect, it } from "vitest";
import { parseMetadata } from "../../web/core/records.ts";

const read = (text: string) => parseMetadata(new TextEncoder().encode(text));
const bins = { low: 0, high: 10, counts: [4, 0, 2] };

it("is read as it was written", () => {
  const metadata = {
    name: "head",
    title: "A head",
    units: "HU",
    source: { format: "DICOM" },
    histogram: bins,
    active_cells: bins,
    suggested_isovalues: [60.5, -3],
    notes: ["The spacing was assumed."],
    other: { of: "another program" },
  };
  expect(read(JSON.stringify(metadata))).toEqual(metadata);
});

it.each([
  ["name", "5"],
  ["title", '["a"]'],
  ["units", "{}"],
  ["source", '"DICOM"'],
  ["source", "null"],
  ["histogram", "[1, 2]"],
  ["histogram", '{"low": 0, "high": 10}'],
  ["histogram", '{"low": 0, "high": 10, "counts": 7}'],
  ["histogram", '{"low": 0, "high": 10, "counts": []}'],
  ["histogram", '{"low": 0, "high": 10, "counts": [1, "2"]}'],
  ["active_cells", '{"low": 0, "high": 10, "counts": [1, -2]}'],
  ["active_cells", '{"low": "0", "high": 10, "counts": [1]}'],
  ["active_cells", '{"low": 10, "high": 10, "counts": [1]}'],
  ["active_cells", `{"low": 0, "high": 1, "counts": [${Array(10_001).fill(1)}]}`],
  ["suggested_isovalues", "60"],
  ["suggested_isovalues", "[60, null]"],
  ["notes", '"a note"'],
  ["notes", "[1]"],
])("leaves out %s in the form %.60s", (name, value) => {
  expect(read(`{"${name}": ${value}, "kept": 1}`)).toEqual({ kept: 1 });
});

it.each(["", "{", "null", "[1]", '"text"'])("is empty if the text is %j", (text) => {
  expect(read(text)).toEqual({});
});
