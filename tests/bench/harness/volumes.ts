import { createHash } from "node:crypto";
import { existsSync, readdirSync, readFileSync, statSync } from "node:fs";
import { join } from "node:path";
import { root } from "./paths.ts";

/** The folder of real volumes: ISOSPLAT_VOLUMES, or ../shared/volumes beside the project. */
export const volumesFolder = process.env.ISOSPLAT_VOLUMES ?? join(root, "../shared/volumes");

/** Checksums by file or folder name, as `sha256sum` prints them. For folders, see digest(). */
function readChecksums(): Map<string, string> {
  const lines = readFileSync(join(root, "tests/bench/volumes.sha256"), "utf8").split("\n");
  return new Map(
    lines
      .map((line) => line.split("  ") as [string, string])
      .filter(([hash]) => hash && !hash.startsWith("#"))
      .map(([hash, name]) => [name, hash]),
  );
}

/**
 * SHA-256 of a file. For a folder: SHA-256 of the lines `<hash> <name>` of its files, sorted by
 * name.
 */
function digest(path: string): string {
  if (!statSync(path).isDirectory())
    return createHash("sha256").update(readFileSync(path)).digest("hex");
  const lines = readdirSync(path)
    .sort()
    .map((name) => `${digest(join(path, name))}  ${name}\n`);
  return createHash("sha256").update(lines.join("")).digest("hex");
}

const checksums = readChecksums();
const verified = new Set<string>();

/** The files of a volume. The data file of a detached header has the same stem. */
function filesOf(name: string): string[] {
  return name.endsWith(".nhdr") ? [name, name.replace(/\.nhdr$/, ".raw.gz")] : [name];
}

/**
 * The path of a volume of volumesFolder by its file or folder name, e.g. "engine.nhdr". Throws if
 * it differs from the recorded checksum, because figures are only comparable for the same input.
 * Returns undefined if it is absent.
 */
export function findVolume(name: string): string | undefined {
  for (const file of filesOf(name)) {
    const path = join(volumesFolder, file);
    if (!existsSync(path)) return undefined;
    if (verified.has(path)) continue;
    const expected = checksums.get(file);
    if (!expected) throw new Error(`${file} is not listed in tests/bench/volumes.sha256`);
    const found = digest(path);
    if (found !== expected)
      throw new Error(`${path}: SHA-256 is ${found}, expected ${expected}: not the same volume`);
    verified.add(path);
  }
  return join(volumesFolder, name);
}

/** Prints the lines of volumes.sha256 for the present content of the folder. */
export function printChecksums(): void {
  for (const entry of readdirSync(volumesFolder).sort()) {
    if (entry !== "INDEX.md") console.log(`${digest(join(volumesFolder, entry))}  ${entry}`);
  }
}
