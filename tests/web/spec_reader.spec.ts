import { readdirSync, readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { readStore } from "../spec_reader/read_store.ts";

const golden = new URL("../golden/v1.0/", import.meta.url);

for (const name of readdirSync(golden).filter((file) => file.endsWith(".isosplat"))) {
  test(`a reader written from FORMAT.md finds its way in ${name}`, () => {
    const store = readStore(readFileSync(new URL(name, golden)));
    expect(store.spacing).toEqual([0.5, 0.5, 2]);
    expect(store.metadata.name).toBe(name.replace(".isosplat", ""));
    const digest = readFileSync(new URL(name.replace(".isosplat", ".txt"), golden), "utf8");
    const found = store.levels.map(({ chunks }, level) => {
      return [level, chunks.length, chunks.reduce((sum, chunk) => sum + chunk.cells, 0)].join(" ");
    });
    const expected = digest.trim().split("\n");
    expect(found).toEqual(expected.map((line) => line.split(" ").slice(0, 3).join(" ")));
  });
}

test("the worked example of FORMAT.md is in the golden store", () => {
  const store = readStore(readFileSync(new URL("tiny.isosplat", golden)));
  expect(store).toMatchObject({ version: [1, 0], fileBytes: 2584, voxels: [3, 3, 3], bits: 8 });
  expect(store.range).toEqual([0, 42]);
  const chunk = { level: 0, block: [0, 0, 0], slab: 0, begin: 0, end: 42 };
  expect(store.levels[0]?.chunks).toEqual([{ ...chunk, offset: 2520, bytes: 32, cells: 8 }]);
});
