/** A project that uses the package: made from the tarball alone, without a network. */
import { execFileSync } from "node:child_process";
import {
  copyFileSync,
  existsSync,
  mkdtempSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../../..", import.meta.url));
export const { version } = JSON.parse(readFileSync(join(root, "package.json"), "utf8")) as {
  version: string;
};
export const tarball = join(root, `build/npm/isosplat-${version}.tgz`);

export interface Consumer {
  folder: string;
  write(file: string, text: string): void;
  remove(): void;
}

/** An empty folder, with the package installed, the README's examples, and their store. */
export function consumer(): Consumer {
  if (!existsSync(tarball)) throw new Error(`${tarball} is missing: npm run build:package`);
  const folder = mkdtempSync(join(tmpdir(), "isosplat-npm-"));
  const write = (file: string, text: string): void => writeFileSync(join(folder, file), text);
  write("package.json", JSON.stringify({ private: true, type: "module" }));
  execFileSync("npm", ["install", "--offline", "--no-audit", "--no-fund", tarball], {
    cwd: folder,
    stdio: ["ignore", "ignore", "inherit"],
  });
  copyFileSync(
    join(root, "build/release/tests/shared/fixture.isosplat"),
    join(folder, "head.isosplat"),
  );
  for (const [file, text] of examples(folder)) write(file, text);
  return { folder, write, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** The code blocks of the installed README whose first line names a file. */
export function examples(folder: string): Map<string, string> {
  const readme = readFileSync(join(folder, "node_modules/isosplat/README.md"), "utf8");
  const blocks = readme.matchAll(/^```\w+\n(?:\/\/|<!--) (\S+)(?: -->)?\n([\s\S]*?)^```$/gm);
  return new Map([...blocks].map(([, file = "", text = ""]) => [file, text]));
}
