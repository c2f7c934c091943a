import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { basename, dirname, join, normalize } from "node:path";

/**
 * One dependency of a folder on another: an `#include`, an `import`, or a link of a CMake target.
 */
export interface Use {
  from: string;
  to: string;
  /** `file: line`, for messages. */
  where: string;
}

const quoted = "[\"']([^\"']+)[\"']";
const includePattern = /^\s*#\s*include\s+"([^"]+)"/gm;
const importPattern = new RegExp(
  [
    `^\\s*(?:import|export)\\b[^;"']*?\\bfrom\\s*${quoted}`,
    `^\\s*import\\s*${quoted}`,
    `\\bimport\\(\\s*${quoted}`,
    `\\bnew URL\\(\\s*${quoted}\\s*,\\s*import\\.meta\\.url`,
  ].join("|"),
  "gm",
);

/** Tracked files below the repository's root whose names match, as `git ls-files` prints them. */
export function trackedFiles(root: string, ...patterns: string[]): string[] {
  const printed = execFileSync("git", ["ls-files", ...patterns], { cwd: root, encoding: "utf8" });
  return printed.split("\n").filter((file) => file !== "" && existsSync(join(root, file)));
}

/** The folder of a file; for a generated file, the folder of its source. */
function folderOf(file: string): string {
  // The WebAssembly modules and their JavaScript are built from shared/bindings/wasm.
  if (file.startsWith("@wasm/") || file.startsWith("build/wasm/web/"))
    return "shared/bindings/wasm";
  return dirname(file);
}

/**
 * Includes of C++ files, without those of other libraries (files that are not in the repository).
 */
export function includesOf(root: string, files: string[]): Use[] {
  return files.flatMap((file) =>
    [...readFileSync(join(root, file), "utf8").matchAll(includePattern)].flatMap((match) => {
      const target = match[1] ?? "";
      const beside = join(dirname(file), target);
      const installed = join("shared/core/include", target);
      const found = [target, installed, beside].find((path) => existsSync(join(root, path)));
      return found
        ? [{ from: dirname(file), to: dirname(found), where: `${file}: ${target}` }]
        : [];
    }),
  );
}

/** Imports of TypeScript files, including type imports, without npm packages. */
export function importsOf(root: string, files: string[]): Use[] {
  return files.flatMap((file) =>
    [...readFileSync(join(root, file), "utf8").matchAll(importPattern)].flatMap((match) => {
      const target = match.slice(1).find((group) => group !== undefined) ?? "";
      const path = target.startsWith(".") ? normalize(join(dirname(file), target)) : target;
      if (!target.startsWith(".") && !target.startsWith("@wasm/")) return [];
      return [{ from: dirname(file), to: folderOf(path), where: `${file}: ${target}` }];
    }),
  );
}

interface Targets {
  /** The folder of each library and program of the project. */
  folders: Map<string, string>;
  links: Use[];
}

/** Targets that CMakeLists.txt files define and link, without other libraries. */
export function targetsOf(root: string, files: string[]): Targets {
  const texts = files
    .filter((file) => basename(file) === "CMakeLists.txt")
    .map((file) => ({
      file,
      text: readFileSync(join(root, file), "utf8").replace(/#.*$/gm, ""),
    }));
  const folders = new Map<string, string>();
  for (const { file, text } of texts) {
    for (const [, name] of text.matchAll(
      /\badd_(?:library|executable)\s*\(\s*([\w-]+)(?=[\s)])/g,
    )) {
      if (name) folders.set(name, dirname(file));
    }
  }
  const links = texts.flatMap(({ file, text }) =>
    [...text.matchAll(/\btarget_link_libraries\s*\(([^)]*)\)/g)].flatMap(([, words = ""]) => {
      const [target = "", ...others] = words.trim().split(/\s+/);
      const from = folders.get(target);
      return others.flatMap((name) => {
        const to = folders.get(name);
        return from && to ? [{ from, to, where: `${file}: ${target} → ${name}` }] : [];
      });
    }),
  );
  return { folders, links };
}
