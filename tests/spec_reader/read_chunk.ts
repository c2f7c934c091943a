// A decoder of chunks, written from shared/core/codec/CHUNK.md alone. It shares no code with the rest,
// follows the terms and the order of the document, and is not optimised.

/** The properties of a chunk that the directory states. */
export interface ChunkShape {
  /** The block's cells along each axis. */
  blockCells: [number, number, number];
  begin: number;
  end: number;
  cells: number;
  hasIntervals: boolean;
}

export interface Cell {
  place: [number, number, number];
  /** x fastest. */
  corners: number[];
  min: number;
  max: number;
}

/** The tables at the end of CHUNK.md. */
export interface Tables {
  quads: number[][];
  tokens: number[][];
  weights: number[][];
}

type Row = (x: number) => number;

function check(condition: boolean, what: string): asserts condition {
  if (!condition) throw new Error(`malformed chunk: ${what}`);
}

const range = (n: number) => Array.from({ length: n }, (_, i) => i);
const sum = (numbers: number[]) => numbers.reduce((a, b) => a + b, 0);
const unfold = (u: number) => (u % 2 ? (u + 1) / 2 : -u / 2);

// Distributions.

export function readTables(specification: string): Tables {
  const frequencies = (letters: string, total: number) => {
    const numbers = [...letters].map((letter) => {
      const c = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz".indexOf(letter);
      return Math.floor(2 ** (c / 4));
    });
    const most = numbers.indexOf(Math.max(...numbers));
    numbers[most] = (numbers[most] as number) + total - sum(numbers);
    return numbers;
  };
  // Each line of a table's block begins with the number of its first entry.
  const rows = (name: string) =>
    (specification.split(`\n\`${name}\`: `)[1]?.split("```")[1] ?? "")
      .trim()
      .split("\n")
      .map((line) => line.trim().split(/ +/).slice(1));
  return {
    quads: rows("kQuadTable")
      .flat()
      .map((text) => frequencies(text, 4096)),
    tokens: rows("kTokenTable")
      .flat()
      .map((text) => frequencies(text, 2048)),
    weights: rows("kDefaultWeights").map((row) => row.map(Number)),
  };
}

// The two streams: bits from the front, symbols from the back.

class Streams {
  #bit = 0;
  #end: number;
  #states: number[];
  #symbols = 0;

  constructor(private bytes: Uint8Array) {
    this.#end = bytes.length - 16;
    check(this.#end >= 0, "no states");
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.#states = range(4).map((i) => view.getUint32(bytes.length - 4 - 4 * i, true));
    check(
      this.#states.every((x) => x >= 2 ** 16),
      "a state is too small",
    );
  }

  bits(n: number): number {
    let value = 0;
    for (let i = 0; i < n; ++i, ++this.#bit) {
      check(this.#bit < 8 * this.#end, "bits and words overlap");
      const bit = ((this.bytes[this.#bit >> 3] as number) >> (this.#bit & 7)) & 1;
      value += bit * 2 ** i;
    }
    return value;
  }

  symbol(distribution: number[], k: number): number {
    const n = this.#symbols++ % 4;
    let x = this.#states[n] as number;
    const slot = x % 2 ** k;
    let s = 0;
    let start = 0;
    while (start + (distribution[s] as number) <= slot) start += distribution[s++] as number;
    x = (distribution[s] as number) * Math.floor(x / 2 ** k) + slot - start;
    if (x < 2 ** 16) {
      this.#end -= 2;
      check(this.#end >= 0, "too few words");
      const word = (this.bytes[this.#end] as number) + 256 * (this.bytes[this.#end + 1] as number);
      x = x * 2 ** 16 + word;
    }
    this.#states[n] = x;
    return s;
  }

  finish() {
    check(
      this.#states.every((x) => x === 2 ** 16),
      "a state at the end",
    );
    while (this.#bit % 8) check(this.bits(1) === 0, "bits that are not zeros");
    check(this.#bit / 8 === this.#end, "bits and words do not meet");
  }
}

/** A 3D array of numbers. Elements beyond its bounds read as `outside`. */
class Box {
  #values: number[];

  constructor(
    readonly size: [number, number, number],
    private outside: number,
  ) {
    this.#values = new Array(size[0] * size[1] * size[2]).fill(outside);
  }

  holds(x: number, y: number, z: number): boolean {
    const [nx, ny, nz] = this.size;
    return x >= 0 && x < nx && y >= 0 && y < ny && z >= 0 && z < nz;
  }

  get(x: number, y: number, z: number): number {
    return this.holds(x, y, z) ? (this.#values[this.#at(x, y, z)] as number) : this.outside;
  }

  set(x: number, y: number, z: number, value: number) {
    this.#values[this.#at(x, y, z)] = value;
  }

  #at(x: number, y: number, z: number): number {
    return x + this.size[0] * (y + this.size[1] * z);
  }
}

// The mask.

function readQuad(streams: Streams, tables: Tables, flags: Box, x: number, y: number, z: number) {
  const quad = [
    [x, y],
    [x + 1, y],
    [x, y + 1],
    [x + 1, y + 1],
  ] as [number, number][];
  const around = [
    ...quad.map(([i, j]) => flags.get(i, j, z - 1)),
    flags.get(x - 1, y, z),
    flags.get(x - 1, y + 1, z),
    flags.get(x, y - 1, z),
    flags.get(x + 1, y - 1, z),
  ];
  const context = sum(around.map((flag, bit) => flag << bit));
  const symbol = streams.symbol(tables.quads[context] as number[], 12);
  quad.forEach(([i, j], bit) => {
    const flag = (symbol >> bit) & 1;
    if (flags.holds(i, j, z)) flags.set(i, j, z, flag);
    else check(flag === 0, "a flag outside the block");
  });
}

function readMask(streams: Streams, tables: Tables, cells: [number, number, number]): Box {
  const bricks = new Box(cells.map((n) => Math.ceil(n / 4)) as [number, number, number], 0);
  const [bx, by, bz] = bricks.size;
  for (let z = 0; z < bz; ++z) {
    for (let y = 0; y < by; y += 2) {
      for (let x = 0; x < bx; x += 2) readQuad(streams, tables, bricks, x, y, z);
    }
  }
  const mask = new Box(cells, 0);
  for (const b of range(bx * by * bz)) {
    const brick = [b % bx, Math.floor(b / bx) % by, Math.floor(b / bx / by)];
    const [x, y, z] = brick as [number, number, number];
    if (!bricks.get(x, y, z)) continue;
    for (const k of range(4)) {
      for (const quad of range(4)) {
        const [i, j] = [4 * x + 2 * (quad % 2), 4 * y + 2 * (quad >> 1)];
        if (mask.holds(i, j, 4 * z + k)) readQuad(streams, tables, mask, i, j, 4 * z + k);
      }
    }
  }
  return mask;
}

// The header, and residuals.

function readHeader(streams: Streams, tables: Tables, hasIntervals: boolean) {
  check(streams.bits(2) === 0, "version");
  const wide = streams.bits(1) === 1;
  const shift = hasIntervals ? streams.bits(3) : 0;
  const base = streams.bits(4);
  const merge = streams.bits(3);
  check(merge <= 4, "merge");
  const models = new Map<number, number>();
  for (const group of range(hasIntervals ? 4 : 2)) {
    for (const level of range((11 >> merge) + 1)) {
      if (streams.bits(1)) models.set(12 * group + level, streams.bits(8));
    }
  }
  check(models.size > 0 && [...models.values()].every((m) => m < 150), "models");
  const weights = tables.weights.map((row) => [...row]);
  if (streams.bits(1)) {
    const classes = streams.bits(16);
    check(classes !== 0, "no classes");
    const rice = streams.bits(3);
    for (const row of weights.filter((_, c) => (classes >> c) & 1)) {
      row.forEach((weight, tap) => {
        if (tap === 1) return;
        let ones = 0;
        while (ones < 12 && streams.bits(1)) ++ones;
        const u = ones < 12 ? ones * 2 ** rice + streams.bits(rice) : streams.bits(13);
        row[tap] = weight + unfold(u);
        check(Math.abs(row[tap]) <= 1023, "a weight");
      });
      row[1] = 0;
      row[1] = 128 - sum(row);
    }
  }
  return { wide, shift, base, merge, models, weights };
}

type Header = ReturnType<typeof readHeader>;

function octave(e: number): number {
  const b = Math.floor(Math.log2(e + 2));
  return 2 * b - 2 + (e + 2 - 2 ** b >= 2 ** (b - 1) ? 1 : 0);
}

function readResidual(streams: Streams, tables: Tables, header: Header, group: number, e: number) {
  const level = Math.min(Math.max(octave(e) - header.base, 0), 11) >> header.merge;
  const m = header.models.get(12 * group + level);
  check(m !== undefined, "a context without a model");
  const run = Math.floor(m / 75);
  const i = m % 75;
  const row = i < 23 ? 27 * run + i : 27 * run + 23 + ((i - 23) % 4);
  const k = i < 23 ? 0 : 1 + Math.floor((i - 23) / 4);
  const t = streams.symbol(tables.tokens[row] as number[], 11);
  const base = t < 16 ? t : 2 ** (t - 12);
  return unfold(base * 2 ** k + streams.bits(k + (t < 16 ? 0 : t - 12)));
}

// The lattice and the intervals.

/** A field chunk: the corners of cells that are those of the store's chunk. bits: of the field. */
export function readFieldChunk(
  bytes: Uint8Array,
  blockCells: ChunkShape["blockCells"],
  cells: Cell[],
  bits: number,
  tables: Tables,
): number[][] {
  const mask = new Box(blockCells, 0);
  for (const { place } of cells) mask.set(...place, 1);
  const shape = {
    blockCells,
    begin: 0,
    end: bits === 8 ? 256 : 65536,
    cells: cells.length,
    hasIntervals: false,
  };
  return readChunk(bytes, shape, tables, mask).map(({ corners }) => corners);
}

/** known: the mask of a chunk that has none, a field chunk. */
export function readChunk(
  bytes: Uint8Array,
  shape: ChunkShape,
  tables: Tables,
  known?: Box,
): Cell[] {
  const streams = new Streams(bytes);
  const header = readHeader(streams, tables, shape.hasIntervals);
  const [cx, cy, cz] = shape.blockCells;
  const mask = known ?? readMask(streams, tables, shape.blockCells);

  const points = new Box([cx + 1, cy + 1, cz + 1], 0);
  const places = range(cx * cy * cz)
    .map((c): Cell["place"] => [c % cx, Math.floor(c / cx) % cy, Math.floor(c / cx / cy)])
    .filter((place) => mask.get(...place));
  check(places.length === shape.cells, "the number of cells");
  const cornersOf = ([x, y, z]: Cell["place"]) =>
    range(8).map((c): Cell["place"] => [x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2)]);
  for (const place of places) for (const corner of cornersOf(place)) points.set(...corner, 1);

  const rows = new Map<number, Row>(); // those with points, by y + 1000 z
  const middle = Math.min(Math.floor((shape.begin + shape.end) / 2), 65535) - 32768;
  let latest: Row = () => middle;
  const energies = new Map<number, number>();
  const energy = (x: number, y: number) => energies.get(x + 1000 * y) ?? 4;

  const readRow = (y: number, z: number, eOf: Row, residualAt: (x: number, r: number) => void) => {
    const [backDown, backUp] = [rows.get(y + 1 + 1000 * (z - 1)), rows.get(y - 1 + 1000 * (z - 1))];
    let [up, back, corner] = [rows.get(y - 1 + 1000 * z), rows.get(y + 1000 * (z - 1)), backUp];
    if (up && back) {
      corner ??= up;
    } else {
      up = back = corner = up ?? back ?? backUp ?? backDown ?? latest;
    }
    const below = backDown ?? back;

    const v = new Map<number, number>();
    v.set(-1, up(0)).set(-2, up(0));
    for (let x = 0; x <= cx; ++x) {
      const [low, high] = [Math.min(up(x), back(x)), Math.max(up(x), back(x))];
      v.set(x, low + high - Math.min(Math.max(corner(x), low), high));
    }
    const row: Row = (x) => v.get(x) as number;
    for (let x = 0; x <= cx; ++x) {
      if (!points.get(x, y, z)) continue;
      const kind =
        points.get(x - 1, y, z) +
        2 * points.get(x, y - 1, z) +
        4 * points.get(x, y, z - 1) +
        8 * points.get(x, y - 1, z - 1);
      const taps = [up, back, below, corner].flatMap((r) => [r(x - 1), r(x), r(x + 1)]);
      taps.push(row(x - 1), row(x - 2));
      const weights = header.weights[kind] as number[];
      const predicted = Math.floor(
        (sum(taps.map((tap, i) => tap * (weights[i] as number))) + 64) / 128,
      );
      const most = header.wide ? 32767 : 255 - 32768;
      const prediction = Math.min(Math.max(predicted, -32768), most);
      const group = (kind & 6) === 6 ? 0 : 1;
      const residual = readResidual(streams, tables, header, group, eOf(x));
      const quantized = (prediction + residual + 32768) & 65535;
      v.set(x, quantized - 32768);
      residualAt(x, residual);
    }
    v.set(cx + 1, row(cx));
    rows.set(y + 1000 * z, row);
    latest = row;
  };

  const cells: Cell[] = [];
  let before = 0;
  const readCell = (place: Cell["place"]) => {
    const corners = cornersOf(place).map(([x, y, z]) => (rows.get(y + 1000 * z) as Row)(x) + 32768);
    let [min, max] = [Math.min(...corners), Math.max(...corners)];
    if (shape.hasIntervals) {
      const [low, high] = [min >> header.shift, max >> header.shift];
      const e = 2 * (high - low) + Math.min(before, 65535);
      const below = readResidual(streams, tables, header, 2, e);
      const beyond = readResidual(streams, tables, header, 3, e);
      before = Math.abs(below) + Math.abs(beyond);
      min = ((low - below) << header.shift) & 65535;
      max = (((high + beyond + 1) << header.shift) - 1) & 65535;
    }
    check(known !== undefined || min < max, "an empty interval");
    cells.push({ place, corners, min, max });
  };

  for (let z = 0; z <= cz; ++z) {
    const found: [number, number][] = [];
    for (let y = 0; y <= cy; ++y) {
      if (!range(cx + 1).some((x) => points.get(x, y, z))) continue;
      const eOf = (x: number) =>
        sum(
          range(9).map((n) => {
            const [i, j] = [(n % 3) - 1, Math.floor(n / 3) - 1];
            return energy(x + i, y + j) * (2 - Math.abs(i)) * (2 - Math.abs(j));
          }),
        );
      readRow(y, z, eOf, (x, residual) => {
        found.push([x + 1000 * y, Math.min(Math.abs(residual), 4095)]);
      });
    }
    for (const [place, value] of found) energies.set(place, value);
    for (const place of places) if (place[2] === z - 1) readCell(place);
  }
  streams.finish();
  return cells;
}
