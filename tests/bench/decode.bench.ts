// Rate of decoding chunks to packed samples on one core: natively, and in Node with the WebAssembly
// module that the page's workers use.
import { type ChildProcess, spawn } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { chunkShapeBytes, writeChunkShape } from "../../build/wasm/web/layouts.js";
import type { CoreModule } from "../../web/core/index.ts";
import { loadCore, maxHeaderBytes } from "../../web/core/index.ts";
import { recordOf } from "../../web/core/records.ts";
import type { Bench, Benchmark } from "./harness/benchmark.ts";
import { root } from "./harness/paths.ts";
import { median, type Reach } from "./harness/results.ts";

interface Case {
  volume: string;
  /** Undefined: all chunks of level 0. */
  isovalue?: number;
  /** Smallest allowed native rate, million samples per second. */
  native?: number;
  /** Smallest allowed ratio of the WebAssembly rate to the native rate. */
  ratio?: number;
}

const cases: Case[] = [
  { volume: "bunny_ct_i16.nrrd", native: 60, ratio: 0.55 },
  { volume: "bunny_ct_i16.nrrd", isovalue: 1000.5, native: 60, ratio: 0.55 },
  { volume: "engine.nhdr" },
  { volume: "engine.nhdr", isovalue: 60.5 },
];

interface Decoding {
  seconds: number;
  samples: number;
}

/** The native decoder in a separate process, which keeps the chunks in memory. */
class NativeDecoder {
  readonly #child: ChildProcess;
  readonly #lines: AsyncIterator<string>;

  constructor(program: string, store: string, [low, high]: [number, number]) {
    const child = spawn(program, [store, String(low), String(high)], {
      stdio: ["pipe", "pipe", "inherit"],
    });
    this.#child = child;
    this.#lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  }

  async decode(): Promise<Decoding> {
    this.#child.stdin?.write("\n");
    const { value, done } = await this.#lines.next();
    if (done) throw new Error("isosplat_decode_bench ended");
    return JSON.parse(value) as Decoding;
  }

  close(): void {
    this.#child.kill();
  }
}

/** The bytes of a chunk, and its IsosplatChunkShape, in the module's memory. */
interface HeldChunk {
  bytes: Uint8Array;
  shape: Uint8Array;
  cells: number;
}

/** CPU time in seconds, as the native decoder measures it. */
function cpuSeconds(): number {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e6;
}

/** Calls the module's functions directly, because web/core would add copies. */
class WasmDecoder {
  readonly #module: CoreModule;
  readonly #core: number;
  readonly #chunks: HeldChunk[];
  readonly #at: number;

  private constructor(module: CoreModule, chunks: HeldChunk[]) {
    this.#module = module;
    this.#core = module._isosplat_core_create();
    this.#chunks = chunks;
    this.#at = module._malloc(
      chunkShapeBytes + Math.max(...chunks.map(({ bytes }) => bytes.length)),
    );
  }

  static async open(path: string, [low, high]: [number, number]): Promise<WasmDecoder> {
    const wasmBinary = readFileSync(join(root, "build/wasm/web/isosplat-core.wasm"));
    const { default: createModule } = await import("../../build/wasm/web/isosplat-core.js");
    const module = (await createModule({ wasmBinary })) as CoreModule;
    const file = new Uint8Array(readFileSync(path));
    const store = (await loadCore({ module })).openStore(file.subarray(0, maxHeaderBytes));
    for (const page of store.pages()) {
      store.addPage(page.index, file.subarray(page.offset, page.offset + page.bytes));
    }
    const chunks = store.chunksFor(0, low, high).filter(({ cells }) => cells > 0);
    store.close();
    return new WasmDecoder(
      module,
      chunks.map((chunk) => ({
        bytes: file.subarray(chunk.offset, chunk.offset + chunk.bytes),
        shape: recordOf(chunkShapeBytes, writeChunkShape, chunk),
        cells: chunk.cells,
      })),
    );
  }

  decode(): Decoding {
    let seconds = 0;
    let samples = 0;
    for (const { bytes, shape, cells } of this.#chunks) {
      this.#module.HEAPU8.set(shape, this.#at);
      this.#module.HEAPU8.set(bytes, this.#at + chunkShapeBytes);
      const begin = cpuSeconds();
      const status = this.#module._isosplat_core_decode_packed(
        this.#core,
        this.#at + chunkShapeBytes,
        bytes.length,
        this.#at,
      );
      seconds += cpuSeconds() - begin;
      if (status !== 0) throw new Error(`a chunk does not decode: status ${status}`);
      samples += cells;
    }
    return { seconds, samples };
  }
}

async function runCase(bench: Bench, program: string, store: string, the: Case): Promise<void> {
  const name = the.volume.replace(/\..*/, "");
  const what = the.isovalue === undefined ? name : `${name} ${the.isovalue}`;
  bench.say(what);
  const range: [number, number] =
    the.isovalue === undefined ? [-1e30, 1e30] : [the.isovalue, the.isovalue];
  const native = new NativeDecoder(program, store, range);
  try {
    const wasm = await WasmDecoder.open(store, range);
    let samples = 0;
    const rate = (decoding: Decoding) => {
      samples = decoding.samples;
      return decoding.samples / 1e6 / decoding.seconds;
    };
    const rates = await bench.interleave({
      native: async () => rate(await native.decode()),
      wasm: () => rate(wasm.decode()),
    });
    const atLeast = (mark?: number): Reach | undefined =>
      mark === undefined ? undefined : { atLeast: mark };
    bench.report(what, "samples", "", samples);
    bench.report(what, "native", "Msamples/s", rates.native, atLeast(the.native));
    bench.report(what, "WASM in Node", "Msamples/s", rates.wasm);
    const ratio = median(rates.wasm) / median(rates.native);
    bench.report(what, "WASM / native", "×", ratio, atLeast(the.ratio));
  } finally {
    native.close();
  }
}

export default {
  title: "decoding on one core, natively and as WASM, to what the GPU takes",
  quick: true,
  async run(bench) {
    const program = join(root, "build/release/tests/bench/decode/isosplat_decode_bench");
    if (!existsSync(program)) throw new Error(`${program} is not built: npm run build`);
    const stores = new Map<string, string>();
    for (const the of cases) {
      const volume = bench.volume(the.volume);
      if (!volume) continue;
      let store = stores.get(volume);
      if (!store) {
        store = `${bench.folder}/${stores.size}.isosplat`;
        bench.say(`building the store of ${the.volume}`);
        await bench.command(bench.isosplat, ["build", volume, "-o", store, "--quiet"]);
        stores.set(volume, store);
      }
      await runCase(bench, program, store, the);
    }
  },
} satisfies Benchmark;
