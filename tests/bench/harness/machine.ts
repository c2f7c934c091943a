import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { cpus, loadavg, totalmem } from "node:os";
import { join } from "node:path";
import { root } from "./paths.ts";

export interface Machine {
  /**
   * The machine's processor, cores and memory. Figures of machines with the same name may be
   * compared.
   */
  name: string;
  /** The project's version, from package.json. */
  version: string;
  /** Short commit; ends in "+" if files differ from it. */
  commit: string;
  /** Conditions that may disturb timings now, as text. */
  warnings: string[];
}

function git(...args: string[]): string {
  try {
    return execFileSync("git", args, { cwd: root, encoding: "utf8" }).trim();
  } catch {
    return "";
  }
}

/** The machine that runs the benchmarks, and conditions that may disturb them. */
export function inspectMachine(): Machine {
  const cores = cpus();
  const gib = Math.round(totalmem() / 2 ** 30);
  const model = (cores[0]?.model ?? "unknown processor").replace(/\s+/g, " ").trim();
  const { version } = JSON.parse(readFileSync(join(root, "package.json"), "utf8")) as {
    version: string;
  };
  const dirty = git("status", "--porcelain", "--untracked-files=no") !== "";
  const warnings: string[] = [];
  const load = loadavg()[0] ?? 0;
  if (load > 0.5)
    warnings.push(`load is ${load.toFixed(2)}: something else runs; ratios hold, times do not`);
  if (cores.length < 2) warnings.push("one core: figures for two threads mean nothing");
  return {
    name: `${model}, ${cores.length} cores, ${gib} GiB`,
    version,
    commit: git("rev-parse", "--short", "HEAD") + (dirty ? "+" : ""),
    warnings,
  };
}
