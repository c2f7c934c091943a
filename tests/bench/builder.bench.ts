// Building stores with the WebAssembly module: the rate relative to the program's, and whether the
// stores are the same. Two threads encode in both.
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { MessageChannel, Worker } from "node:worker_threads";
import { brotliCompressSync } from "node:zlib";
import { type Port, PortEncoder } from "../../web/builder/index.ts";
import { loadCore } from "../../web/core/index.ts";
import { describeStore } from "../support/describe_store.ts";
import { builderProgram, buildLocally } from "../support/local_build.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { readNrrd } from "./harness/flying_edges.ts";
import { median } from "./harness/results.ts";

const threads = 2;

interface Native {
  megavoxels_per_second: number[];
  user_seconds: number;
}

async function compare(bench: Bench, tool: string, path: string): Promise<void> {
  const what = path.replace(/.*\//, "").replace(/\..*/, "");
  bench.say(what);
  const core = await loadCore();
  const file = join(bench.folder, `${what}.isosplat`);
  await bench.command(bench.isosplat, ["build", path, "-o", file]);
  const store = readFileSync(file);
  const volume = describeStore(core, store);
  const { data } = readNrrd(path);
  const megavoxels = (volume.voxels[0] * volume.voxels[1] * volume.voxels[2]) / 1e6;

  const program = await builderProgram();
  const workers = Array.from({ length: threads }, () => {
    const { port1, port2 } = new MessageChannel();
    const worker = new Worker(new URL("./harness/encode_thread.mjs", import.meta.url), {
      workerData: { port: port2, program },
      transferList: [port2],
    });
    return { worker, encoder: new PortEncoder(port1 as unknown as Port), port: port1 };
  });
  const encoders = workers.map(({ encoder }) => encoder);
  let isSame = true;
  const processor: { wasm: number[]; native: number[] } = { wasm: [], native: [] };
  const rates = await bench.interleave({
    native: async () => {
      const args = [path, "--threads", String(threads)];
      const { stdout } = await bench.command(tool, args);
      const built = JSON.parse(stdout) as Native;
      processor.native.push(built.user_seconds);
      return median(built.megavoxels_per_second);
    },
    wasm: async () => {
      const before = process.cpuUsage();
      const seconds = await bench.time(async () => {
        const built = await buildLocally(program, encoders, volume, data);
        isSame &&= Buffer.compare(built.store, store) === 0;
      });
      processor.wasm.push(process.cpuUsage(before).user / 1e6);
      return megavoxels / seconds;
    },
  });
  for (const { worker, port } of workers) {
    port.close();
    await worker.terminate();
  }
  bench.report(what, "same bytes as the program's", "", isSame ? 1 : 0, { atLeast: 1 });
  bench.report(what, "rate, program", "Mvoxel/s", rates.native);
  bench.report(what, "rate, WebAssembly", "Mvoxel/s", rates.wasm);
  const ratio = median(rates.wasm) / median(rates.native);
  bench.report(what, "rate, WebAssembly / program", "", ratio, { atLeast: 0.4 });
  const processorRatio = median(processor.native) / median(processor.wasm);
  bench.report(what, "processor time, program / WebAssembly", "", processorRatio);
}

export default {
  title: "building stores as WebAssembly, against the program",
  async run(bench) {
    const tool = join(bench.root, "build/release/tests/bench/build/isosplat_build_bench");
    if (!existsSync(tool)) throw new Error(`${tool} is not built: npm run build`);
    const bytes = ["wasm", "js"].map((suffix) =>
      readFileSync(join(bench.root, `build/wasm/web/isosplat-builder.${suffix}`)),
    );
    const packed = bytes.reduce((sum, part) => sum + brotliCompressSync(part).byteLength, 0);
    bench.report("module", "on the network", "KB", packed / 1e3, { atMost: 120 });
    for (const volume of ["engine.nhdr", "bonsai.nhdr", "bunny_ct_i16.nrrd"]) {
      const path = bench.volume(volume);
      if (path) await compare(bench, tool, path);
    }
  },
} satisfies Benchmark;
