// npm run bench [-- NAME… | quick | plot | --list | --checksums]
//
// Runs the benchmarks of this folder and of tests/evidence (NAME.bench.ts), prints a table, and adds rows to
// results/NAME.csv. Names the inputs that are missing, and skips them. An input with another checksum
// is an error.
import { existsSync, readdirSync } from "node:fs";
import { join, relative } from "node:path";
import { drawPlots } from "./documents/plots.ts";
import { writeTables } from "./documents/tables.ts";
import { Bench, type Benchmark } from "./harness/benchmark.ts";
import { inspectMachine } from "./harness/machine.ts";
import { isosplat, root } from "./harness/paths.ts";
import { formatTable, reached, saveResults } from "./harness/results.ts";
import { printChecksums } from "./harness/volumes.ts";

const folders = ["tests/bench", "tests/evidence"].map((folder) => join(root, folder));
/** The folder of each benchmark. */
const places = new Map(
  folders.flatMap((folder) =>
    readdirSync(folder)
      .filter((file) => file.endsWith(".bench.ts"))
      .map((file): [string, string] => [file.slice(0, -".bench.ts".length), folder]),
  ),
);
const known = [...places.keys()].sort();

async function load(name: string): Promise<Benchmark> {
  const file = join(places.get(name) ?? "", `${name}.bench.ts`);
  return ((await import(file)) as { default: Benchmark }).default;
}

async function runOne(name: string): Promise<boolean> {
  const benchmark = await load(name);
  console.log(`\n${name}: ${benchmark.title}`);
  const bench = new Bench();
  const end = () => {
    bench.close();
    process.exit(130);
  };
  process.once("SIGINT", end).once("SIGTERM", end);
  let failed = false;
  try {
    await benchmark.run(bench);
  } catch (error) {
    failed = true;
    console.error(`\n${name} failed: ${error instanceof Error ? error.message : error}`);
  } finally {
    bench.close();
    process.off("SIGINT", end).off("SIGTERM", end);
  }
  if (bench.figures.length > 0) {
    console.log(`\n${formatTable(bench.figures)}\n`);
    console.log(`  added to ${relative(root, saveResults(name, machine, bench.figures))}`);
  }
  for (const line of bench.skipped) console.log(`  skipped ${line}`);
  const missed = bench.figures.filter((figure) => reached(figure) === false).length;
  if (missed > 0) console.log(`  ${missed} of ${bench.figures.length} figures missed their mark`);
  return !failed;
}

const args = process.argv.slice(2);
if (args.includes("--checksums")) {
  printChecksums();
  process.exit(0);
}
if (args[0] === "plot") {
  writeTables();
  for (const file of await drawPlots()) console.log(`  drawn ${file}`);
  process.exit(0);
}
if (args.includes("--list")) {
  for (const name of known) {
    const { title, quick } = await load(name);
    console.log(`${name.padEnd(12)} ${title}${quick ? " (quick)" : ""}`);
  }
  process.exit(0);
}
const chosen: string[] = [];
for (const arg of args) {
  if (arg !== "quick") chosen.push(arg);
  else for (const name of known) if ((await load(name)).quick) chosen.push(name);
}
const unknown = chosen.filter((name) => !known.includes(name));
if (unknown.length > 0) {
  console.error(`No benchmark ${unknown.join(", ")}. There are: quick, ${known.join(", ")}`);
  process.exit(2);
}
if (!existsSync(isosplat)) {
  console.error(`${relative(root, isosplat)} is not built. Run: npm run build`);
  process.exit(1);
}

const machine = inspectMachine();
console.log(`Isosplat ${machine.version} (${machine.commit}) on ${machine.name}`);
for (const warning of machine.warnings) console.log(`  warning: ${warning}`);
let ok = true;
for (const name of args.length > 0 ? new Set(chosen) : known) ok = (await runOne(name)) && ok;
process.exit(ok ? 0 : 1);
