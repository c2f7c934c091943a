// Compares Isosplat and other programs for browsers: the same isosurface over the same links.
import type { Bench, Benchmark } from "../bench/harness/benchmark.ts";
import { links } from "../bench/stream/visit.ts";
import { programsFor, type Surface } from "./peer_visits/programs.ts";
import { measureProgram } from "./peer_visits/visit_peer.ts";

const surfaces = [
  { name: "engine", isovalue: 60.5, next: 100.5 },
  { name: "bonsai", isovalue: 40.5, next: 71.5 },
  { name: "aneurysm", isovalue: 100.5, next: 150.5 },
];

async function measure(bench: Bench, surface: Surface, runs: number): Promise<void> {
  const { name, isovalue, next } = surface;
  const { programs, close } = await programsFor(bench, surface);
  try {
    for (const link of links) {
      for (const program of programs) {
        bench.say(`${name}, ${link.name}, ${program.name}`);
        await measureProgram(bench, program, `${name} ${isovalue}`, link, next, runs);
      }
    }
  } finally {
    close();
  }
}

export default {
  title: "Isosplat and other programs for browsers, over the same links",
  async run(bench) {
    const wanted = process.env.ISOSPLAT_BENCH_PEERS ?? "";
    for (const each of surfaces.filter(({ name }) => name.includes(wanted))) {
      const volume = bench.volume(`${each.name}.nhdr`);
      if (volume) await measure(bench, { ...each, volume }, Math.min(bench.runs, 3));
    }
  },
} satisfies Benchmark;
