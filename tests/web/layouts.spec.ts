/** The records that C++ and TypeScript exchange, which the build generates from records.h. */
import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import * as layouts from "../../build/wasm/web/layouts.js";
import {
  colourings,
  colourMaps,
  fieldScales,
  shadings,
  splatKinds,
} from "../../web/viewer/types.ts";

const file = (path: string) => readFileSync(new URL(`../../${path}`, import.meta.url), "utf8");

test("the committed types are those that the build generates", () => {
  const generated = file("build/wasm/layouts.d.ts");
  expect(
    file("web/core/generated.d.ts"),
    "records.h has changed: cp build/wasm/layouts.d.ts web/core/generated.d.ts",
  ).toBe(generated);
});

test("the module exports every name that the types declare, and no other", () => {
  const declared = file("web/core/generated.d.ts").matchAll(/export (?:const|function) (\w+)/g);
  expect(Object.keys(layouts).sort()).toEqual([...declared].map(([, name]) => name).sort());
});

test("records are as large as C lays them out", () => {
  expect(layouts.chunkBytes).toBe(8 + 14 * 4);
  expect(layouts.drawnChunkBytes).toBe(4 + 4 * layouts.regionWords);
  expect(layouts.visibilityBytes).toBe(4 + 2 * 4 * layouts.regionWords);
  expect(layouts.selectionViewBytes).toBe(16 * 8 + 5 * 8 + 2 * 4);
});

test("the viewer's lists have the enumerations of the renderer, in their order", () => {
  expect(splatKinds).toEqual(layouts.splatKindNames);
  expect(shadings).toEqual(layouts.shadingNames);
  expect(colourings).toEqual(layouts.colourByNames);
  expect(fieldScales).toEqual(layouts.fieldScaleNames);
  expect(colourMaps).toEqual(layouts.colourMapNames);
});

test("a record reads as it was written", () => {
  const camera = {
    target: [1.5, -2, 3] as [number, number, number],
    distance: 4,
    azimuth: 5,
    elevation: -6,
    roll: 7,
    fieldOfView: 30,
    orthographic: 1,
  };
  const data = new DataView(new ArrayBuffer(8 + layouts.cameraBytes));
  layouts.writeCamera(data, 8, camera);
  expect(layouts.readCamera(data, 8)).toEqual(camera);
  expect(data.getFloat64(0, true)).toBe(0);
  expect(data.getFloat64(8, true)).toBe(1.5);
});
