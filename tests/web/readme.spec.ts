import { execFileSync, spawn } from "node:child_process";
import {
  existsSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  rmSync,
  statSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

const root = fileURLToPath(new URL("../..", import.meta.url));
const binaries = join(root, "build/release/native/cli");

/** The file that the README calls head.nii.gz: a ball as NIfTI, 24³ bytes. */
function header(): Buffer {
  const size = 24;
  const file = Buffer.alloc(352 + size ** 3);
  file.writeInt32LE(348, 0);
  [3, size, size, size, 1, 1, 1, 1].forEach((n, i) => {
    file.writeInt16LE(n, 40 + 2 * i);
  });
  file.writeInt16LE(2, 70); // unsigned bytes
  file.writeInt16LE(8, 72);
  for (let i = 0; i < 4; ++i) file.writeFloatLE(1, 76 + 4 * i);
  file.writeFloatLE(352, 108);
  file.writeFloatLE(1, 112);
  file.write("n+1\0", 344, "latin1");
  for (let i = 0; i < size ** 3; ++i) {
    const x = (i % size) - 11.5;
    const y = (Math.floor(i / size) % size) - 11.5;
    const z = Math.floor(i / size ** 2) - 11.5;
    file[352 + i] = Math.max(0, 200 - 14 * Math.hypot(x, y, z));
  }
  return gzipSync(file);
}

/** The file that the README calls blast.vthb, and its patches: 4³ cells, of which the inner ones are refined. */
function writeAdaptiveGrid(folder: string): void {
  const patch = (level: number, box: string, origin: string, spacing: number) => {
    const values = Array.from({ length: 64 }, (_, i) => i % 5).join(" ");
    const piece = `<Piece Extent="0 4 0 4 0 4"><CellData><DataArray type="Float32" format="ascii">${values}</DataArray></CellData></Piece>`;
    writeFileSync(
      join(folder, `blast_${level}.vti`),
      `<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 4 0 4 0 4" Origin="${origin}" Spacing="${spacing} ${spacing} ${spacing}">${piece}</ImageData></VTKFile>`,
    );
    return `<Block level="${level}" spacing="${spacing} ${spacing} ${spacing}"><DataSet index="0" amr_box="${box}" file="blast_${level}.vti"/></Block>`;
  };
  const levels = patch(0, "0 3 0 3 0 3", "0 0 0", 1) + patch(1, "2 5 2 5 2 5", "1 1 1", 0.5);
  writeFileSync(
    join(folder, "blast.vthb"),
    `<VTKFile type="vtkOverlappingAMR" version="1.1"><vtkOverlappingAMR origin="0 0 0" grid_description="XYZ">${levels}</vtkOverlappingAMR></VTKFile>`,
  );
}

/** The file that the README calls flow.vtu: four tetrahedra around a point. */
function writeMesh(folder: string): void {
  const array = (type: string, name: string, numbers: string, components = 1) =>
    `<DataArray type="${type}" Name="${name}" NumberOfComponents="${components}" format="ascii">${numbers}</DataArray>`;
  const points = array("Float32", "Points", "0 0 0 4 0 0 0 4 0 0 0 4 1 1 1", 3);
  const cells =
    array("Int32", "connectivity", "4 1 2 3 0 4 2 3 0 1 4 3 0 1 2 4") +
    array("Int32", "offsets", "4 8 12 16") +
    array("UInt8", "types", "10 10 10 10");
  writeFileSync(
    join(folder, "flow.vtu"),
    `<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid><Piece NumberOfPoints="5" NumberOfCells="4"><PointData>${array("Float32", "pressure", "1 2 3 4 0")}</PointData><Points>${points}</Points><Cells>${cells}</Cells></Piece></UnstructuredGrid></VTKFile>`,
  );
}

const readme = readFileSync(join(root, "README.md"), "utf8");
const commands = [...readme.matchAll(/^isosplat ([^#\n]*)/gm)].map((match) =>
  (match[1] ?? "")
    .trim()
    .split(/\s+/)
    .map((word) => word.replace(/^'(.*)'$/, "$1")),
);

describe("the README's commands", () => {
  let folder = "";
  beforeAll(() => {
    folder = mkdtempSync(join(tmpdir(), "isosplat-readme-"));
    writeFileSync(join(folder, "head.nii.gz"), header());
    writeFileSync(join(folder, "dose.nii.gz"), header());
    writeFileSync(join(folder, "organs.nii.gz"), header()); // each value is a label
    writeAdaptiveGrid(folder);
    writeMesh(folder);
    for (const step of [1, 2]) writeFileSync(join(folder, `step_${step}.nii.gz`), header());
    const layer = { store: "head.isosplat", surfaces: [{ isovalue: 100 }] };
    const scene = { format: "isosplat-scene", version: 1, layers: [layer] };
    writeFileSync(join(folder, "scene.json"), JSON.stringify(scene));
  });
  afterAll(() => rmSync(folder, { recursive: true, force: true }));

  const env = { ...process.env, XDG_CACHE_HOME: "" };
  const program = join(binaries, "isosplat");
  const finite = commands.filter(([name]) => name !== "view" && name !== "serve");
  const serving = commands.filter(([name]) => name === "view" || name === "serve");

  it("are there", () => {
    expect(new Set(finite.map(([name]) => name))).toEqual(
      new Set(["build", "info", "publish", "extract", "render", "bundle"]),
    );
    expect(serving.map(([name]) => name)).toEqual(["view", "serve", "view"]);
  });

  // `render` compiles its shaders without a cache, which takes long on a busy machine.
  const longest = 120_000;
  it.each(finite.map((args) => [args.join(" "), args] as const))(
    "isosplat %s",
    (_, args) => {
      const files = readdirSync(folder);
      const expanded = args.flatMap((word) => {
        const [begin = "", end] = word.split("*");
        return end === undefined
          ? word
          : files.filter((file) => file.startsWith(begin) && file.endsWith(end));
      });
      const printed = execFileSync(program, expanded, { cwd: folder, encoding: "utf8", env });
      const output = args[args.indexOf("-o") + 1];
      const site = args[args.indexOf("--to") + 1];
      if (args.includes("-o") && output) {
        expect(statSync(join(folder, output)).size).toBeGreaterThan(1000);
      } else if (args.includes("--to") && site) {
        expect(existsSync(join(folder, site, "index.html"))).toBe(true);
      } else {
        expect(printed).toContain("24");
      }
    },
    longest,
  );

  it.each(serving.map((args) => [args.join(" "), args] as const))(
    "isosplat %s",
    async (_, args) => {
      env.XDG_CACHE_HOME = join(folder, "cache");
      const child = spawn(program, [...args, "--port", "0"], { cwd: folder, env });
      let printed = "";
      const url = await new Promise<string>((resolve, reject) => {
        const listen = (data: Buffer) => {
          printed += data.toString();
          const found = printed.match(/http:\/\/[^\s"]+/)?.[0];
          if (found) resolve(found);
        };
        child.stdout.on("data", listen);
        child.stderr.on("data", listen);
        child.on("error", reject);
        child.on("close", (code) => reject(new Error(`exit status ${code}: ${printed}`)));
      });
      // The address that view prints has a token, without which the volume cannot be read.
      const isScene = args[1]?.endsWith(".isobundle");
      const list = new URL(isScene ? "/v1/scenes" : "/v1/volumes", url);
      const token = new URL(url).searchParams.get("token");
      expect(token !== null).toBe(args[0] === "view");
      if (token) expect((await fetch(list)).status).toBe(401);
      const headers = token ? { Authorization: `Bearer ${token}` } : {};
      const answer = await fetch(list, { headers });
      const { volumes, scenes } = (await answer.json()) as {
        volumes?: { voxels: number[] }[];
        scenes?: { name: string; steps: number }[];
      };
      if (isScene) {
        expect(scenes).toMatchObject([{ name: new URL(url).searchParams.get("scene"), steps: 2 }]);
      } else {
        expect(volumes?.map(({ voxels }) => voxels)).toEqual([[24, 24, 24]]);
      }
      const ended = new Promise((resolve) => child.on("close", resolve));
      child.kill("SIGTERM");
      expect(await ended).toBe(0);
    },
  );
});

describe("documents", () => {
  const documents = execFileSync("git", ["ls-files", "*.md"], { cwd: root, encoding: "utf8" });
  it.each(documents.trim().split("\n"))("%s links to files that exist", (name) => {
    const text = readFileSync(join(root, name), "utf8").replace(/```[\s\S]*?```/g, "");
    const links = [...text.matchAll(/\]\((?!https?:|#)([^)#\s]+)/g)].map((match) => match[1] ?? "");
    for (const link of links) {
      expect(existsSync(join(root, dirname(name), link)), `${name}: ${link}`).toBe(true);
    }
  });
});
