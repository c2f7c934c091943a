import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import { trackedFiles } from "../support/source_graph.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const read = (file: string) => readFileSync(join(root, file), "utf8");

describe("the glossary", () => {
  const file = "docs/GLOSSARY.md";
  const rows = [...read(file).matchAll(/^\| (.+?) \| (.+) \| (.+) \|$/gm)]
    .map(([, term = "", meaning = "", places = ""]) => ({ term, meaning, places }))
    .filter(({ term }) => term !== "term");

  it("has each term once, in alphabetical order", () => {
    const terms = rows.map(({ term }) => term);
    expect(terms.length).toBeGreaterThan(30);
    expect(terms).toEqual([...new Set(terms)].sort());
  });

  it.each(rows.map((row) => [row.term, row] as const))(
    "defines %s in the stated file",
    (_, row) => {
      expect(row.meaning).toMatch(/\.$/);
      const links = [...row.places.matchAll(/`(\w+)`\]\(([^)]+)\)/g)];
      expect(links).not.toEqual([]);
      for (const [, name = "", link = ""] of links) {
        const path = join(dirname(file), link);
        expect(existsSync(join(root, path)), path).toBe(true);
        expect(read(path), `${path} has ${name}`).toMatch(new RegExp(`\\b${name}\\b`));
      }
    },
  );
});

describe("documents", () => {
  // `folder/file.extension`, or a folder, of the repository; not build outputs.
  const path = /`((?:shared|native|server|web|tests|docs|\.ci)\/[\w./-]*[\w])`/g;
  const named = trackedFiles(root, "*.md")
    .filter((document) => document !== "CHANGELOG.md")
    .flatMap((document) =>
      [...read(document).matchAll(path)].map((match) => [document, match[1] ?? ""] as const),
    );

  it("name files and folders", () => expect(named.length).toBeGreaterThan(20));

  it.each(named)("%s names %s, which exists", (_, name) => {
    expect(existsSync(join(root, name))).toBe(true);
  });
});

describe("the list of dependencies", () => {
  it("is what npm run dependencies writes", () => {
    const script = join(root, ".ci/dependencies.mjs");
    const printed = execFileSync(process.execPath, [script, "--print"], { encoding: "utf8" });
    expect(read("docs/DEPENDENCIES.md")).toBe(printed);
  });

  // Only Debian 12 has these versions.
  const system = existsSync("/etc/os-release") ? readFileSync("/etc/os-release", "utf8") : "";
  it.runIf(/^ID=debian$/m.test(system) && /^VERSION_ID="12"$/m.test(system))(
    "has the versions of Debian 12",
    () => {
      const [debian = ""] = read("docs/DEPENDENCIES.md").split("\n## npm packages\n");
      const rows = [...debian.matchAll(/^\| ([a-z][\w.+-]+) \| ([\d.]+) \|/gm)];
      const query = ["-W", "-f", `\${Package} \${Version}\n`, ...rows.map((row) => row[1] ?? "")];
      // dpkg-query fails if a package is not installed, but prints the others.
      const installed = spawnSync("dpkg-query", query, { encoding: "utf8" }).stdout;
      const found = [...installed.matchAll(/^(\S+) (?:\d+:)?(?:.*\+really)?(\d[\d.]*)/gm)];
      expect(found.length).toBeGreaterThan(20);
      const stated = new Map(rows.map(([, name, version]) => [name, version]));
      for (const [, name, version] of found) {
        expect(`${version}.`, name).toMatch(
          new RegExp(`^${(stated.get(name) ?? "").replaceAll(".", "\\.")}\\.`),
        );
      }
    },
  );
});

describe("the version of package.json", () => {
  const { version } = JSON.parse(read("package.json")) as { version: string };
  const packages = /\b(?:lib)?isosplat(?:-dev)?[-_](\d+\.\d+\.\d+(?:[-~]rc\.\d+|rc\d+)?)/g;

  it.each(["README.md", "docs/python.md"])("is in the names of packages that %s has", (file) => {
    const versions = [...read(file).matchAll(packages)].map((match) =>
      match[1]?.replace("~", "-").replace(/(\d)rc(\d)/, "$1-rc.$2"),
    );
    expect(versions.length).toBeGreaterThanOrEqual(3);
    expect([...new Set(versions)]).toEqual([version]);
  });

  it("is the one that CMake projects in documents and tests require", () => {
    const asked = [
      "docs/examples/points/CMakeLists.txt",
      "shared/bindings/library/README.md",
      "tests/install/CMakeLists.txt",
    ].flatMap((file) => [...read(file).matchAll(/find_package\(isosplat ([\d.]+)/g)]);
    expect(asked.length).toBeGreaterThanOrEqual(4);
    for (const [, found] of asked) expect(`${version}.`.startsWith(`${found}.`)).toBe(true);
  });

  it("is that of package-lock.json", () => {
    const lock = JSON.parse(read("package-lock.json"));
    expect([lock.version, lock.packages[""].version]).toEqual([version, version]);
  });
});

describe("links to headings", () => {
  /** The anchor of a heading, as repository hosts form it. */
  const anchor = (heading: string) =>
    heading
      .toLowerCase()
      .replace(/[^\p{L}\p{N} _-]/gu, "")
      .replaceAll(" ", "-");
  const prose = (file: string) => read(file).replace(/```[\s\S]*?```/g, "");
  const links = trackedFiles(root, "*.md").flatMap((document) =>
    [...prose(document).matchAll(/\]\((?!https?:)([^)#\s]*)#([^)\s]+)\)/g)].map(
      ([, path = "", name = ""]) =>
        [document, path === "" ? document : join(dirname(document), path), name] as const,
    ),
  );

  it("exist", () => expect(links.length).toBeGreaterThan(3));

  it.each(links)("%s links to a heading of %s: %s", (_, path, name) => {
    const headings = [...prose(path).matchAll(/^#+ (.+)$/gm)].map((match) =>
      anchor(match[1] ?? ""),
    );
    expect(headings).toContain(name);
  });
});

describe("decision records", () => {
  const folder = "docs/decisions";
  const records = trackedFiles(root, `${folder}/*.md`).filter((file) => /\/\d/.test(file));
  const index = read(`${folder}/README.md`);

  it("are numbered from 001 without a gap", () => {
    expect(records.length).toBeGreaterThanOrEqual(10);
    expect(records.map((file) => file.slice(folder.length + 1, folder.length + 4))).toEqual(
      records.map((_, i) => String(i + 1).padStart(3, "0")),
    );
  });

  it.each(records)("%s has its sections, and a line in the list", (file) => {
    const text = read(file);
    const number = file.slice(folder.length + 1, folder.length + 4);
    expect(text).toMatch(new RegExp(`^# ${number}\\. `));
    const sections = [...text.matchAll(/^## (.+)$/gm)].map((match) => match[1]);
    expect(sections).toEqual(["Context", "Decision", "Consequences", "Figures"]);
    expect(index).toContain(`[${number}](${file.slice(folder.length + 1)})`);
  });
});
