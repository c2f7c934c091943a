import { readFileSync } from "node:fs";
import { join } from "node:path";
import { describe, expect, it } from "vitest";
import { peerTables } from "../bench/documents/peer_tables.ts";
import { documentTables, withTable } from "../bench/documents/tables.ts";
import { exponentOf, orderOf } from "../bench/growth/exponents.ts";
import { root } from "../bench/harness/paths.ts";
import { newestRows, readResults } from "../bench/harness/table.ts";

describe("figures in documents", () => {
  it.each(documentTables().map((table) => [table.name, table] as const))(
    "%s are those of the results (npm run bench -- plot writes them)",
    (_, table) => {
      const text = readFileSync(join(root, table.file), "utf8");
      expect(withTable(text, table)).toBe(text);
    },
  );

  it("come from the newest run of each figure", () => {
    const text = `machine,case,measure,unit,median,min,max
one,engine,size,MB,3,3,3
one,engine,time,s,5,5,5
two,engine,size,MB,4,4,4
`;
    expect(
      newestRows(text).map(({ machine, measure, median }) => [machine, measure, median]),
    ).toEqual([
      ["two", "size", 4],
      ["one", "time", 5],
    ]);
  });

  it("state where other programs are better than Isosplat, in their versions measured last", () => {
    const measures = readResults("peers").filter(({ case: what }) => what.includes("Isosplat "));
    const rows = (program: string, median: number) =>
      measures
        .filter(({ case: what }) => what === measures[0]?.case)
        .map((row) => ({ ...row, case: `engine 60.5, 20 Mbit/s, 40 ms, ${program}`, median }));
    const text = peerTables([
      ...rows("Isosplat 0.1.0", 2),
      ...rows("vtk.js 1.0.0", 3),
      ...rows("vtk.js 1.1.0", 1),
      ...rows("three.js 1.0.0", 2),
    ]);
    expect(text).toContain("| vtk.js 1.1.0 | **1.0** |");
    expect(text).toContain("- first picture (2.0 s): vtk.js 1.1.0 1.0 s\n");
    expect(text).toContain("| three.js 1.0.0 | 2.0 |");
    expect(text).not.toContain("vtk.js 1.0.0");
  });

  it("cannot be written into a document without marks for them", () => {
    const table = { file: "A.md", name: "sizes", table: "| 1 |" };
    expect(withTable("<!-- sizes -->\n| 0 |\n<!-- end -->\n", table)).toContain("| 1 |\n<!-- end");
    expect(() => withTable("| 0 |\n", table)).toThrow("A.md: expected <!-- sizes -->");
  });
});

describe("exponents of growth", () => {
  const grown = (exponent: number) =>
    [64, 128, 512].map((n) => ({ voxels: n ** 3, figure: 7 * n ** (3 * exponent) }));

  it.each([0, 2 / 3, 1])("of the power law %f are found", (exponent) => {
    expect(exponentOf(grown(exponent))).toBeCloseTo(exponent, 10);
  });

  it("are least squares if there is no exact power law", () => {
    const [a, b, c] = grown(1);
    const bent = [a, { voxels: b?.voxels ?? 0, figure: 2 * (b?.figure ?? 0) }, c];
    const found = exponentOf(bent as { voxels: number; figure: number }[]);
    // In steps of log 2 of the axis: x = 0, 3, 9 with mean 4, and only y of x = 3 is higher, by 1.
    expect(found).toBeCloseTo(1 + (3 - 4) / (16 + 1 + 25), 10);
  });

  it("need two sizes, and figures above 0", () => {
    expect(() => exponentOf(grown(1).slice(0, 1))).toThrow("at least 2 sizes");
    expect(() => exponentOf(grown(1).map((point) => ({ ...point, figure: 0 })))).toThrow("above 0");
  });

  it("have the name of the nearest order", () => {
    expect([0.1, 0.6, 0.97].map((exponent) => orderOf(exponent, 2 / 3))).toEqual([
      "O(screen)",
      "O(surface)",
      "O(voxels)",
    ]);
    expect(orderOf(0.85, 0.82)).toBe("O(surface)");
  });

  it("that are near to no order lie between two, or beyond all", () => {
    expect(orderOf(0.35, 2 / 3)).toBe("between O(screen) and O(surface)");
    expect(orderOf(1.3, 2 / 3)).toBe("more than O(voxels)");
    expect(orderOf(-0.4, 2 / 3)).toBe("less than O(screen)");
  });
});
