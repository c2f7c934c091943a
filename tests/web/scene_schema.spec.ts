import { readFileSync } from "node:fs";
import { Ajv2020 } from "ajv/dist/2020.js";
import { describe, expect, it } from "vitest";

const folder = new URL("../../shared/core/scene/", import.meta.url);
const read = (name: string) => readFileSync(new URL(name, folder), "utf8");
const validate = new Ajv2020({ allowUnionTypes: true }).compile(
  JSON.parse(read("scene.schema.json")),
);
const example = JSON.parse(read("SCENE.md").match(/```json\n([\s\S]*?)```/)?.[1] ?? "");

describe("the schema of scenes", () => {
  it("accepts the example of SCENE.md", () => {
    expect(validate(example)).toBe(true);
  });

  it("accepts slices, look and measurements, and null for absent ones", () => {
    const point = { position: [0, 0, 0], level: 2, normal: null };
    const members = {
      slices: { along: [0.5, null, 1], plane: null, range: [0, 1], mapped: true },
      look: { kind: "automatic", colour_by: "projection-error", light: { key: 2, sky: null } },
      measurements: [
        { kind: "note", text: "n", points: [point] },
        { kind: "path", text: null, points: [point, point, point] },
      ],
    };
    expect(validate({ ...example, ...members })).toBe(true);
    const field = { name: "p", range: [1, 2], scale: "symmetric", steps: 8, lines: 0.5 };
    expect(validate({ ...example, look: { colour_by: "field", field } })).toBe(true);
    expect(validate({ ...example, look: { field: { name: "p", steps: 0, range: null } } })).toBe(
      true,
    );
    expect(validate({ ...example, slices: null, look: null, measurements: null })).toBe(true);
  });

  it("accepts unknown members", () => {
    expect(validate({ ...example, time: { steps: [0, 1], step: 7 } })).toBe(true);
    expect(validate({ ...example, future: [1], layers: [{ store: "a", more: 1 }] })).toBe(true);
  });

  // The same documents that parse_scene refuses (tests/shared/scene_test.cpp).
  it.each([
    { format: "other" },
    { version: 2 },
    { layers: [] },
    { layers: [{}] },
    { layers: [{ store: "" }] },
    { layers: [{ store: "a", visible: 1 }] },
    { layers: [{ store: "a", transform: [1, 2] }] },
    { layers: [{ store: "a", label: { value: 1.5, voxels: 1, volume: 1 } }] },
    { layers: [{ store: "a", label: { value: 1, voxels: -1, volume: 1 } }] },
    { layers: [{ store: "a", label: { value: 1 } }] },
    { layers: [{ store: "a", surfaces: [{ isovalue: "x" }] }] },
    { layers: [{ store: "a", surfaces: [{ isovalue: 1, opacity: 2 }] }] },
    { layers: [{ store: "a", surfaces: [{ isovalue: 1, colour: "red" }] }] },
    { layers: [{ store: "a", surfaces: Array(9).fill({ isovalue: 1 }) }] },
    { time: { steps: [] } },
    { camera: { target: [0, 0], distance: 1 } },
    { camera: { target: [0, 0, 0], distance: 0 } },
    { clip: { box: { low: [0, 0, 0], high: [1, 1, 2] } } },
    { background: "white" },
    { slices: { along: [0, 1] } },
    { slices: { plane: { normal: [0, 0, 1] } } },
    { look: { kind: "round" } },
    { look: { light: { roughness: 0 } } },
    { look: { colour_by: "field" } },
    { look: { colour_by: "field", field: null } },
    { look: { field: { name: "" } } },
    { look: { field: { name: "p", range: [1] } } },
    { look: { field: { name: "p", steps: 1 } } },
    { look: { field: { name: "p", lines: -1 } } },
    { look: { field: { name: "p", scale: "log" } } },
    { measurements: [{ kind: "angle", points: [{ position: [0, 0, 0] }] }] },
    { measurements: [{ kind: "note", points: [{ position: [0, 0, 0] }] }] },
    { measurements: [{ kind: "point", points: [{ position: [0, 0] }] }] },
  ])("refuses %j", (members) => {
    expect(validate({ ...example, ...members })).toBe(false);
  });
});
