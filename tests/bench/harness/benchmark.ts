import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { isosplat, root } from "./paths.ts";
import type { Figure, Reach } from "./results.ts";
import { findVolume, volumesFolder } from "./volumes.ts";

/** A benchmark: the default export of tests/bench/NAME.bench.ts. */
export interface Benchmark {
  /** One line of description. */
  title: string;
  /** Part of `npm run bench -- quick`, which takes at most ten minutes. */
  quick?: true;
  run(bench: Bench): Promise<void>;
}

/** The result of a command. */
export interface Finished {
  seconds: number;
  /** Peak memory in bytes (Linux: VmHWM, read every 5 ms). */
  peakBytes: number;
  stdout: string;
}

/** The tools of a benchmark: paths, inputs, measurements, and the table of figures. */
export class Bench {
  readonly root = root;
  /** The release build of the program. */
  readonly isosplat = isosplat;
  readonly figures: Figure[] = [];
  readonly skipped: string[] = [];
  #folder: string | undefined;
  readonly #children = new Set<ChildProcess>();

  /** Default number of runs of a timed case: ISOSPLAT_BENCH_RUNS, else 7. */
  readonly runs = Number(process.env.ISOSPLAT_BENCH_RUNS ?? 7);

  /**
   * A volume's path by its name in the folder of real volumes; its checksum is verified. If it is
   * absent, returns undefined and notes this in the table.
   */
  volume(name: string): string | undefined {
    const path = findVolume(name);
    if (!path) this.skip(name, `not in ${volumesFolder}`);
    return path;
  }

  /** A program's path, or undefined (noted in the table). */
  program(name: string): string | undefined {
    const path = spawnSync("sh", ["-c", `command -v ${name}`], { encoding: "utf8" }).stdout.trim();
    if (path) return path;
    this.skip(name, "not installed (.ci/install-packages --for bench)");
    return undefined;
  }

  /** Debian's Python with VTK, or undefined (noted in the table). */
  pythonWithVtk(): string | undefined {
    const python = "/usr/bin/python3";
    if (spawnSync(python, ["-c", "import vtkmodules.vtkFiltersCore"]).status === 0) return python;
    this.skip("VTK", "python3-vtk9 is not installed (.ci/install-packages --for bench)");
    return undefined;
  }

  /** A folder for this benchmark's files, removed at the end. */
  get folder(): string {
    this.#folder ??= mkdtempSync(join(tmpdir(), "isosplat-bench-"));
    return this.#folder;
  }

  /** Prints progress on one line. */
  say(text: string): void {
    console.log(`  ${text}`);
  }

  skip(what: string, why: string): void {
    const line = `${what}: ${why}`;
    if (!this.skipped.includes(line)) this.skipped.push(line);
  }

  /** Adds a figure to the table and the CSV. */
  report(
    what: string,
    measure: string,
    unit: string,
    values: number | number[],
    reach?: Reach,
  ): void {
    const figure: Figure = {
      case: what,
      measure,
      unit,
      values: Array.isArray(values) ? values : [values],
    };
    this.figures.push(reach ? { ...figure, reach } : figure);
  }

  /**
   * Runs the cases in turn, `runs` times after one run that does not count, so that a slowdown of
   * the machine affects all cases alike. Each case returns its measurement.
   */
  async interleave<Name extends string>(
    cases: Record<Name, () => Promise<number> | number>,
    runs = this.runs,
  ): Promise<Record<Name, number[]>> {
    const names = Object.keys(cases) as Name[];
    const values = Object.fromEntries(names.map((name) => [name, [] as number[]]));
    for (let run = -1; run < runs; ++run) {
      for (const name of names) {
        const value = await cases[name]();
        if (run >= 0) values[name]?.push(value);
      }
    }
    return values as Record<Name, number[]>;
  }

  /** The duration of `work` in seconds. */
  async time(work: () => unknown): Promise<number> {
    const begin = performance.now();
    await work();
    return (performance.now() - begin) / 1000;
  }

  /** Runs a command to its end. If it fails, throws an error with its output. */
  async command(program: string, args: string[], env?: Record<string, string>): Promise<Finished> {
    const begin = performance.now();
    const child = this.start(program, args, env);
    let stdout = "";
    let stderr = "";
    child.stdout?.on("data", (data: Buffer) => {
      stdout += data.toString();
    });
    child.stderr?.on("data", (data: Buffer) => {
      stderr += data.toString();
    });
    let peakBytes = 0;
    const poll = setInterval(() => {
      try {
        const status = readFileSync(`/proc/${child.pid}/status`, "utf8");
        peakBytes = Math.max(peakBytes, Number(status.match(/VmHWM:\s+(\d+)/)?.[1] ?? 0) * 1024);
      } catch {
        // It has ended.
      }
    }, 5);
    const code = await new Promise<number | null>((resolve, reject) => {
      child.on("error", reject);
      child.on("close", resolve);
    }).finally(() => clearInterval(poll));
    const seconds = (performance.now() - begin) / 1000;
    if (code !== 0)
      throw new Error(`${program} ${args.join(" ")}: exit status ${code}\n${stderr.slice(-2000)}`);
    return { seconds, peakBytes, stdout };
  }

  /** Starts a command, for example a server. It is ended with the benchmark at the latest. */
  start(program: string, args: string[], env?: Record<string, string>): ChildProcess {
    const child = spawn(program, args, {
      cwd: root,
      env: { ...process.env, ...env },
      stdio: ["ignore", "pipe", "pipe"],
    });
    this.#children.add(child);
    child.on("close", () => this.#children.delete(child));
    return child;
  }

  /** Ends all started commands and removes the folder. */
  close(): void {
    for (const child of this.#children) child.kill("SIGTERM");
    if (this.#folder) rmSync(this.#folder, { recursive: true, force: true });
  }
}
