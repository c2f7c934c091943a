// The bytes of a store's field: for an isovalue by active cell, and beside those of the store's chunks.
// The frame rate of a surface that shows the field, beside that of its own colour.
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { renderProgram } from "./harness/render.ts";
import { serve } from "./stream/serving.ts";
import { launch, links, Visitor } from "./stream/visit.ts";

interface Query {
  chunks: number;
  bytes: number;
  activeCells: number;
  fieldBytes: Record<string, number>;
}

const size = 192;

/** A cube of bytes as NRRD, from 0 to 255 where the value is from 0 to 1. */
function writeCube(path: string, value: (x: number, y: number, z: number) => number): string {
  const voxels = new Uint8Array(size ** 3);
  let at = 0;
  for (let z = 0; z < size; ++z) {
    for (let y = 0; y < size; ++y) {
      for (let x = 0; x < size; ++x) {
        voxels[at++] = Math.round(255 * value(x / size, y / size, z / size));
      }
    }
  }
  const header = `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${size} ${size} ${size}\nencoding: raw\n\n`;
  writeFileSync(path, Buffer.concat([Buffer.from(header), voxels]));
  return path;
}

/** A flow of vortices at two scales (Taylor and Green's, and its fifth harmonic), and its pressure. */
function vortices(folder: string): [string, string] {
  const wave = (n: number, x: number, y: number, z: number) =>
    Math.sin(2 * Math.PI * n * x) * Math.cos(2 * Math.PI * n * y) * Math.cos(2 * Math.PI * n * z);
  const pressure = (n: number, x: number, y: number, z: number) =>
    ((Math.cos(4 * Math.PI * n * x) + Math.cos(4 * Math.PI * n * y)) *
      (Math.cos(4 * Math.PI * n * z) + 2)) /
    6;
  return [
    writeCube(join(folder, "speed.nrrd"), (x, y, z) => {
      return 0.5 + 0.35 * wave(1, x, y, z) + 0.15 * wave(5, x, z, y);
    }),
    writeCube(join(folder, "pressure.nrrd"), (x, y, z) => {
      return 0.5 + 0.35 * pressure(1, x, y, z) + 0.15 * pressure(3, z, x, y);
    }),
  ];
}

interface FrameTimes {
  plain_cpu_ms: number;
  field_cpu_ms: number;
}

/** Frames in the colours of the field for each frame in one colour, by processor time. */
async function measureFrames(bench: Bench, what: string, store: string, isovalue: number) {
  const program = renderProgram("isosplat_field_rate");
  const { stdout } = await bench.command(program, [store, "field", String(isovalue)]);
  const { renderer: _, ...kinds } = JSON.parse(stdout) as Record<string, FrameTimes>;
  for (const [kind, times] of Object.entries(kinds)) {
    const rate = times.plain_cpu_ms / times.field_cpu_ms;
    bench.report(what, `frames, ${kind}`, "×", rate, { atLeast: 0.9 });
  }
}

const storeOf = (bench: Bench) => join(bench.folder, "store.isosplat");

async function measure(bench: Bench, what: string, volume: string, field: string, most?: number) {
  const store = storeOf(bench);
  const call = ["build", volume, "--field", `field=${field}`, "-o", store, "--no-thumbnail"];
  await bench.command(bench.isosplat, [...call, "--force"]);
  const { stdout } = await bench.command(bench.isosplat, ["info", store, "--chunks", "--json"]);
  const queries = (JSON.parse(stdout).chunkReport.queries as Query[]).filter(
    (query) => query.activeCells > 1000,
  );
  const mean = (of: (query: Query) => number) =>
    queries.reduce((sum, query) => sum + of(query), 0) / queries.length;
  const bytesOf = (query: Query) => query.fieldBytes.field as number;
  bench.report(
    what,
    "field, an isovalue",
    "bytes/active cell",
    mean((query) => bytesOf(query) / query.activeCells),
    most === undefined ? undefined : { atMost: most },
  );
  bench.report(
    what,
    "field / chunks, an isovalue",
    "",
    mean((query) => bytesOf(query) / query.bytes),
  );
}

const visits = 5;

/** The times until the page shows a surface, and until it is complete, with its field for each without. */
async function measureVisits(bench: Bench, what: string, store: string, isovalue: number) {
  const url = await serve(bench, [store]);
  const view = `${url}?volume=store&isovalue=${isovalue}`;
  const browser = await launch();
  try {
    for (const link of links) {
      const ratios: [first: number[], complete: number[]] = [[], []];
      const timesOf = async (address: string, first: string): Promise<[number, number]> => {
        const visitor = await Visitor.arrive(browser, link);
        try {
          await visitor.page.goto(address);
          const { shown } = await visitor.mark(first);
          return [shown, (await visitor.mark("isosplat:complete")).at];
        } finally {
          await visitor.leave();
        }
      };
      for (let visit = 0; visit < visits; ++visit) {
        const plain = await timesOf(view, "isosplat:surface");
        const coloured = await timesOf(`${view}&colour-by=field&field=field`, "isosplat:coloured");
        ratios[0].push(coloured[0] / plain[0]);
        ratios[1].push(coloured[1] / plain[1]);
      }
      bench.report(what, `first coloured picture, ${link.name}`, "×", ratios[0], { atMost: 1.2 });
      bench.report(what, `complete, ${link.name}`, "×", ratios[1]);
    }
  } finally {
    await browser.close();
  }
}

export default {
  title: "fields: bytes for an isovalue, first picture, frame rates",
  async run(bench) {
    const pairs: [string, string, string, number?][] = [
      ["fuel, neghip", "fuel.nhdr", "neghip.nhdr", 1.2],
      [
        "viscous fingers, two steps, float",
        "viscous_fingers/016_density_016_064_2.0.vti",
        "viscous_fingers/012_density_012_064_2.0.vti",
      ],
    ];
    bench.say("vortices");
    const [speed, pressure] = vortices(bench.folder);
    await measure(bench, "vortices, pressure", speed, pressure, 1.2);
    await measureFrames(bench, "vortices, pressure", storeOf(bench), 150.5);
    await measureVisits(bench, "vortices, pressure", storeOf(bench), 150.5);
    for (const [what, volume, field, most] of pairs) {
      const [volumePath, fieldPath] = [volume, field].map((name) => {
        const [folder, ...file] = name.split("/");
        const found = bench.volume(folder as string);
        return found && join(found, ...file);
      });
      if (!volumePath || !fieldPath) continue;
      bench.say(what);
      await measure(bench, what, volumePath, fieldPath, most);
    }
  },
} satisfies Benchmark;
