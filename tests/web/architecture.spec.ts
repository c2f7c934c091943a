import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import {
  importsOf,
  includesOf,
  targetsOf,
  trackedFiles,
  type Use,
} from "../support/source_graph.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const document = readFileSync(join(root, "docs/ARCHITECTURE.md"), "utf8");
const diagram = document.match(/```mermaid\n([\s\S]*?)```/)?.[1] ?? "";

const parts = ["shared", "native", "server", "web"];
const sources = trackedFiles(root, ...parts);
const cpp = sources.filter((file) => /\.(h|cpp)$/.test(file));
const typescript = sources.filter((file) => /\.ts$/.test(file));
const folders = new Set([...cpp, ...typescript].map((file) => dirname(file)));
const targets = targetsOf(root, trackedFiles(root, "*CMakeLists.txt"));
const uses = [...includesOf(root, cpp), ...importsOf(root, typescript)].filter(
  ({ from, to }) => from !== to,
);

const drawnFolders = new Set(
  [...diagram.matchAll(/^\s*([\w/]+)\["\1"\]\s*$/gm)].map((match) => match[1] ?? ""),
);
const arrows = [...diagram.matchAll(/^\s*([\w/]+) --> ([\w/]+)\s*$/gm)].map(
  ([, from = "", to = ""]) => ({ from, to }),
);

/** Whether a path of arrows leads from one folder to another without the arrow `without`. */
function leads(from: string, to: string, without?: { from: string; to: string }): boolean {
  const seen = new Set([from]);
  for (const folder of seen) {
    for (const arrow of arrows) {
      if (arrow === without || arrow.from !== folder) continue;
      if (arrow.to === to) return true;
      seen.add(arrow.to);
    }
  }
  return false;
}

const lines = (list: Use[]) => list.map((use) => `${use.from} --> ${use.to}   (${use.where})`);

describe("the diagram of docs/ARCHITECTURE.md", () => {
  it("shows every folder with sources, and no other", () => {
    expect([...drawnFolders].sort()).toEqual([...folders].sort());
  });

  it("has only lines that this test can parse", () => {
    const others = diagram
      .split("\n")
      .map((line) => line.trim())
      .filter((line) => !/^(flowchart .*|subgraph .*|direction .*|end|)$/.test(line));
    expect(others.length).toBe(drawnFolders.size + arrows.length);
    for (const { from, to } of arrows) {
      expect(folders).toContain(from);
      expect(folders).toContain(to);
    }
  });

  it("has an arrow, or a chain of them, for every include and import", () => {
    expect(uses.length).toBeGreaterThan(100);
    expect(lines(uses.filter(({ from, to }) => !leads(from, to)))).toEqual([]);
  });

  it("has an arrow, or a chain of them, for every library that a target links", () => {
    const links = targets.links.filter(
      ({ from, to }) => folders.has(from) && folders.has(to) && from !== to,
    );
    expect(links.length).toBeGreaterThan(10);
    expect(lines(links.filter(({ from, to }) => !leads(from, to)))).toEqual([]);
  });

  it("has no arrow without an include or import", () => {
    const idle = arrows.filter(
      (arrow) => !uses.some(({ from, to }) => from === arrow.from && to === arrow.to),
    );
    expect(idle).toEqual([]);
  });

  it("has no cycle", () => {
    expect([...folders].filter((folder) => leads(folder, folder))).toEqual([]);
  });

  it("has no arrow that a chain of others implies", () => {
    expect(arrows.filter((arrow) => leads(arrow.from, arrow.to, arrow))).toEqual([]);
  });
});

describe("folders", () => {
  it("with C++ sources have a CMake target", () => {
    const compiled = new Set(
      cpp.filter((file) => file.endsWith(".cpp")).map((file) => dirname(file)),
    );
    const built = new Set(targets.folders.values());
    expect([...compiled].filter((folder) => !built.has(folder))).toEqual([]);
  });

  it("of web/ import from others the file that declares a thing", () => {
    // index.ts is for programs outside of web/, and for import() of a whole folder.
    const indexes = typescript.flatMap((file) =>
      [...readFileSync(join(root, file), "utf8").matchAll(/\bfrom "(\.\.\/[^"]*)";/g)]
        .filter(([, target = ""]) => target.endsWith("/index.ts"))
        .map(([statement]) => `${file}: ${statement}`),
    );
    expect(indexes).toEqual([]);
  });

  it("use nothing of tests/", () => {
    expect(lines(uses.filter(({ to }) => to.split("/")[0] === "tests"))).toEqual([]);
  });

  // shared/bindings/wasm binds the core to JavaScript: a module keeps its state in one object, and
  // write_layouts is a program that the build runs.
  const isBinding = (file: string) => file.startsWith("shared/bindings/wasm/");
  const core = cpp.filter((file) => /^shared\/(core|render)\//.test(file));
  const found = (files: string[], pattern: RegExp) =>
    files.flatMap((file) =>
      [...readFileSync(join(root, file), "utf8").matchAll(pattern)].map(
        ([text]) => `${file}: ${text.trim()}`,
      ),
    );

  it("of the core have no variables that outlive a call", () => {
    // Variables at the start of a line are in a namespace: code of functions and classes is indented.
    const variable =
      /^(?:\s*(?:static|thread_local)\s+(?!const\b|constexpr\b)[^()\n]*[;={]|(?!using|namespace|return|class|struct|enum|template|typedef|extern|friend|static|inline constexpr|constexpr|const|[#/} ])[\w:<>,]+(?: [\w:<>,]+)* \w+(?:\[[^\]\n]*\])?(?: = [^;\n]*|\{[^;\n]*\})?;$)/gm;
    expect(found(core, variable)).toEqual([]);
    expect(found(cpp.filter(isBinding), variable)).toEqual([
      "shared/bindings/wasm/mesh_api.cpp: static State instance;",
      "shared/bindings/wasm/renderer_state.cpp: static State instance;",
    ]);
  });

  it("of the core print nothing, and use no files and threads", () => {
    const system =
      /\b(?:printf|fprintf|puts|fputs|fopen|fwrite)\(|\bstd::(?:cout|cerr|clog|[io]?fstream|thread|jthread|mutex)\b/g;
    expect(found(core, system)).toEqual([]);
    expect(found(cpp.filter(isBinding), system).length).toBeGreaterThan(0);
  });

  it("of native/ but the programs use nothing of the server", () => {
    const native = [...folders].filter((folder) => folder.startsWith("native/"));
    const rooms = [...folders].filter((folder) => /^server(\/|$)/.test(folder));
    const users = native.filter((folder) => rooms.some((room) => leads(folder, room)));
    expect(users).toEqual(["native/cli", "native/mpi"]);
  });

  it.each([
    ["shared", /^shared\//],
    ["server", /^(server|shared)(\/|$)/],
    ["web", /^(web\/|shared\/bindings\/wasm$)/],
    ["web/core", /^shared\/bindings\/wasm$/],
    ["web/stream", /^web\/(core|texts)$/],
    ["web/viewer", /^(web\/(stream|core|texts)|shared\/bindings\/wasm)$/],
    ["shared/core", /^shared\/core\//],
    ["shared/render", /^shared\/(render|core)(\/|$)/],
    ["shared/import", /^shared\/(import|core|system)(\/|$)/],
  ])("of %s use only %s", (name, allowed) => {
    const own = uses.filter(({ from }) => `${from}/`.startsWith(`${name}/`));
    expect(own.length).toBeGreaterThan(0);
    expect(lines(own.filter(({ to }) => !allowed.test(to)))).toEqual([]);
  });
});
