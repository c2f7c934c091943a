import { readdirSync, readFileSync } from "node:fs";
import { crc32 } from "node:zlib";
import { describe, expect, test } from "vitest";
import { type Cell, readChunk, readFieldChunk, readTables } from "../spec_reader/read_chunk.ts";
import { type Chunk, readStore, type Store } from "../spec_reader/read_store.ts";

const golden = new URL("../golden/", import.meta.url);
const stores = ["v1.0/", "v1.1/"].flatMap((version) =>
  readdirSync(new URL(version, golden))
    .filter((file) => file.endsWith(".isosplat"))
    .map((file) => version + file),
);
const core = (name: string) =>
  readFileSync(new URL(`../../shared/core/${name}`, import.meta.url), "utf8");
const specification = core("codec/CHUNK.md");
const tables = readTables(specification);

test("the specification's tables match the code", () => {
  expect(tables.quads.length).toBe(256);
  expect(tables.tokens.length).toBe(54);
  expect(tables.weights.length).toBe(16);
  const code = core("codec/chunk_tables.cpp");
  const of = (name: string) => code.split(`${name}[`)[1]?.split("\n};")[0] ?? "";
  const words = (text: string) => [...text.matchAll(/"(\w+)"/g)].map((match) => match[1]);
  const inDocument = (name: string) =>
    (specification.split(`\n\`${name}\`: `)[1]?.split("```")[1] ?? "").match(/[A-Za-z]\w+/g);
  expect(inDocument("kQuadTable")).toEqual(words(of("kQuadTable")));
  expect(inDocument("kTokenTable")).toEqual(words(of("kTokenTable")));
  expect(tables.weights).toEqual(
    [...of("kDefaultWeights").matchAll(/\{(-?\d[^}]*)\}/g)].map((match) =>
      match[1]?.split(",").map(Number),
    ),
  );
});

test("limits in the documents match the code", () => {
  const header = readFileSync(new URL("../../server/server.h", import.meta.url), "utf8");
  const http = readFileSync(new URL("../../server/HTTP.md", import.meta.url), "utf8");
  const mebibytes = (name: string) =>
    Number(header.match(new RegExp(`uint64_t ${name} = uint64_t\\{(\\d+)\\} << 20`))?.[1]);
  expect(http).toContain(`at most ${mebibytes("directory_bytes")} MiB of each store`);
  expect(http).toContain(`More than ${mebibytes("query_bytes")} MiB of chunks`);
  expect(http).toContain(`more than ${mebibytes("query_directory_bytes")} MiB of directory pages`);
  expect(http).toContain(`keeps in memory (at most ${mebibytes("page_asset_bytes")} MiB)`);
});

type Level = Store["levels"][number];
const blockCellsOf = (level: Level, chunk: Chunk) =>
  level.cells.map((n, axis) => Math.min(64, n - 64 * (chunk.block[axis] as number))) as [
    number,
    number,
    number,
  ];
const bytesOf = (file: Uint8Array, chunk: Chunk) =>
  file.subarray(chunk.offset, chunk.offset + chunk.bytes);

function readCells(file: Uint8Array, level: Level, chunk: Chunk): Cell[] {
  const shape = {
    ...chunk,
    blockCells: blockCellsOf(level, chunk),
    hasIntervals: chunk.level > 0,
  };
  return readChunk(bytesOf(file, chunk), shape, tables);
}

/** A cell as tests/golden/digest.h writes it for its CRC. */
function digestBytes({ place, corners, min, max }: Cell): Uint8Array {
  const numbers = Uint16Array.of(...corners, min, max);
  return Uint8Array.of(...place, ...new Uint8Array(numbers.buffer));
}

describe.each(stores)("%s", (name) => {
  const file = readFileSync(new URL(name, golden));
  const store = readStore(file);
  const digest = readFileSync(new URL(name.replace(".isosplat", ".txt"), golden), "utf8");

  test("a reader written from FORMAT.md finds all parts", () => {
    expect(store.spacing).toEqual([0.5, 0.5, 2]);
    expect(store.metadata.name).toBe(name.replace(/^.*\/|\.isosplat$/g, ""));
  });

  test("a decoder written from CHUNK.md finds the cells, corners, intervals and fields", () => {
    const line = (l: number, level: Level, cells: Uint8Array[]) => {
      const crc = cells.reduce((crc, bytes) => crc32(bytes, crc), 0);
      return `${l} ${level.chunks.length} ${cells.length} ${crc.toString(16).padStart(8, "0")}\n`;
    };
    const found = store.levels.map((level, l) => {
      const cells = level.chunks.flatMap((chunk) => readCells(file, level, chunk));
      return line(l, level, cells.map(digestBytes));
    });
    for (const field of store.fields) {
      found.push(`${field.name}\n`);
      field.levels.forEach((level, l) => {
        const corners = level.chunks.flatMap((chunk, i) => {
          const of = store.levels[l]?.chunks[i] as Chunk;
          expect({ ...chunk, offset: 0, bytes: 0 }).toEqual({ ...of, offset: 0, bytes: 0 });
          const cells = readCells(file, level, of);
          const blockCells = blockCellsOf(level, chunk);
          return readFieldChunk(bytesOf(file, chunk), blockCells, cells, field.bits, tables);
        });
        const bytes = corners.map((values) => new Uint8Array(Uint16Array.from(values).buffer));
        found.push(line(l, level, bytes));
      });
    }
    expect(found.join("")).toBe(digest);
  });
});

test("a reader written from FORMAT.md finds what a store states about its fields", () => {
  const { version, fields } = readStore(readFileSync(new URL("v1.1/fields.isosplat", golden)));
  expect(version).toEqual([1, 1]);
  const [phase, temperature] = fields;
  expect(phase).toMatchObject({ name: "phase", bits: 8, scale: 1, maxError: 0, missingVoxels: 0 });
  expect(phase?.range).toEqual([0, 104]);
  expect(temperature).toMatchObject({ name: "temperature", bits: 16, hasMissing: true });
  expect(temperature?.missingVoxels).toBeGreaterThan(5 * 14 * 12);
  expect(temperature?.offset).toBeCloseTo(300, 1);
});

describe("the worked examples", () => {
  const file = readFileSync(new URL("v1.0/tiny.isosplat", golden));
  const store = readStore(file);
  const level = store.levels[0] as Store["levels"][number];

  /** Compares a document's hexadecimal dumps, "ADDRESS  BYTE BYTE …", with the file. */
  function expectBytes(document: string, addressDigits: number, start: number): number {
    const text = readFileSync(new URL(`../../shared/core/${document}`, import.meta.url), "utf8");
    const line = new RegExp(`^([0-9a-f]{${addressDigits}})  ((?:[0-9a-f]{2} ?)+)`, "gm");
    const dumps = [...text.matchAll(line)];
    for (const [, address, bytes] of dumps) {
      const at = start + Number.parseInt(address as string, 16);
      const expected = (bytes as string).trim().split(" ");
      const found = [...file.subarray(at, at + expected.length)];
      expect(found.map((byte) => byte.toString(16).padStart(2, "0"))).toEqual(expected);
    }
    return dumps.length;
  }

  test("show the bytes of the golden store", () => {
    expect(expectBytes("store/FORMAT.md", 6, 0)).toBe(25);
    expect(expectBytes("codec/CHUNK.md", 2, 2520)).toBe(3);
  });

  test("describe the content of the golden store", () => {
    expect(store).toMatchObject({ version: [1, 0], fileBytes: 2584, voxels: [3, 3, 3], bits: 8 });
    expect(store.range).toEqual([0, 42]);
    const chunk = { level: 0, block: [0, 0, 0], band: 0, begin: 0, end: 42 };
    expect(level.chunks).toEqual([{ ...chunk, offset: 2520, bytes: 32, cells: 8 }]);
    const cells = readCells(file, level, level.chunks[0] as Chunk);
    for (const { place, corners, min, max } of cells) {
      const least = 16 * place[0] + 4 * place[1] + place[2];
      expect([min, max]).toEqual([least, least + 21]);
      expect(corners).toEqual([0, 16, 4, 20, 1, 17, 5, 21].map((code) => least + code));
    }
    expect(cells.filter(({ min, max }) => min <= 20.5 && 20.5 < max).length).toBe(7);
  });
});
