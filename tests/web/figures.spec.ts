import { readFileSync } from "node:fs";
import { join } from "node:path";
import { describe, expect, it } from "vitest";
import { documentTables, withTable } from "../bench/documents/tables.ts";
import { root } from "../bench/harness/paths.ts";
import { newestRows } from "../bench/harness/table.ts";

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

  it("cannot be written where a document has no place for them", () => {
    const table = { file: "A.md", name: "sizes", table: "| 1 |" };
    expect(withTable("<!-- sizes -->\n| 0 |\n<!-- end -->\n", table)).toContain("| 1 |\n<!-- end");
    expect(() => withTable("| 0 |\n", table)).toThrow("A.md: expected <!-- sizes -->");
  });
});
