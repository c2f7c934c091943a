/** Zarr hierarchies in folders of this device: the files of a drop, or of a ZIP. */
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { afterAll, beforeAll, expect, test } from "vitest";
import { loadCore } from "../../web/core/index.ts";
import { zarrFolder } from "../../web/device/zarr_volume.ts";
import { replaceCodecs } from "../../web/zarr/codecs.ts";
import { openImage } from "../../web/zarr/open_image.ts";
import type { ZarrScale } from "../../web/zarr/types.ts";
import { addressOfFolder, zarrSource } from "../../web/zarr/zarr_files.ts";
import { builderProgram, buildLocally, localEncoder } from "../support/local_build.ts";
import { writeArray, writeGroup } from "../support/zarr.ts";
import { plainZarr, voxels, zarrVariants } from "../support/zarr_variants.ts";
import { expectedVoxels, readVoxels } from "../support/zarr_voxels.ts";

const isosplat = fileURLToPath(new URL("../../build/release/native/cli/isosplat", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "isosplat-zarr-files-"));
beforeAll(replaceCodecs);
afterAll(() => rmSync(folder, { recursive: true, force: true }));

/** All files below a folder, by their paths in it. */
function filesIn(path: string): Map<string, Blob> {
  const names = readdirSync(path, { recursive: true, encoding: "utf8" });
  const files = names.filter((name) => statSync(join(path, name)).isFile());
  return new Map(files.map((name) => [name, new Blob([readFileSync(join(path, name))])]));
}

async function voxelsOf(address: string, scale: ZarrScale, files: Map<string, Blob>) {
  const source = zarrSource(new URL(address), files);
  return { voxels: await readVoxels(source, scale), absent: source.absent };
}

test.each(zarrVariants)("an array of %s", async (name, options) => {
  const path = join(folder, name.replaceAll(/\W+/g, "-"));
  await writeArray(join(path, "a b.zarr"), options);
  const files = filesIn(path);
  const image = await openImage(addressOfFolder("a b.zarr"), files);
  const [scale] = image.scales as [ZarrScale];
  expect(scale.description).toMatchObject({ voxels, type: "u16", format: "Zarr", name: "a b" });
  const found = await voxelsOf(image.address, scale, files);
  expect(found.voxels).toEqual(expectedVoxels());
  expect(found.absent).toBe(0);
});

test("an image at the root of a ZIP, and one in a folder", async () => {
  const axes = ["z", "y", "x"].map((name) => ({ name, type: "space", unit: "micrometer" }));
  const datasets = [
    { path: "0", coordinateTransformations: [{ type: "scale", scale: [2, 0.5, 0.5] }] },
  ];
  const path = join(folder, "image");
  writeGroup(join(path, "x/y.ome.zarr"), 2, { multiscales: [{ version: "0.4", axes, datasets }] });
  await writeArray(join(path, "x/y.ome.zarr/0"), plainZarr);
  for (const [root, where] of [
    [path, "x/y.ome.zarr"],
    [join(path, "x/y.ome.zarr"), ""],
  ] as const) {
    const files = filesIn(root);
    const listed = [...files.keys()].map((name) => ({ path: name, file: new File([], name) }));
    expect(zarrFolder(listed)).toBe(where);
    const image = await openImage(addressOfFolder(where), files);
    const [scale] = image.scales as [ZarrScale];
    expect(scale.path).toBe("0");
    expect(scale.description.spacing).toEqual([0.0005, 0.0005, 0.002]);
    expect((await voxelsOf(image.address, scale, files)).voxels).toEqual(expectedVoxels());
  }
  expect(zarrFolder([{ path: "a/zarr.json.txt", file: new File([], "a") }])).toBeUndefined();
});

test("the store is the program's", async () => {
  const path = join(folder, "same");
  const isAbsent = (chunk: readonly number[]) => chunk.join() === "1,0,2";
  await writeArray(join(path, "a.zarr"), { ...plainZarr, fill: 7, isAbsent });
  const built = join(path, "a.isosplat");
  execFileSync(isosplat, ["build", join(path, "a.zarr"), "-q", "--no-thumbnail", "-o", built]);
  const core = await loadCore();
  const store = core.openStore(readFileSync(built));
  const { file = "", path_hash = "" } = store.info.metadata.source ?? {};
  const { contentId } = store.info;
  store.close();

  const files = filesIn(path);
  const image = await openImage(addressOfFolder("a.zarr"), files);
  const [scale] = image.scales as [ZarrScale];
  const { voxels, absent } = await voxelsOf(image.address, scale, files);
  const notes = [
    ...(scale.description.notes ?? []),
    `${absent} of 27 chunks are absent: their voxels have the fill value`,
  ];
  const program = await builderProgram();
  const local = await buildLocally(
    program,
    [await localEncoder(program)],
    // A browser does not know the path of a folder.
    { ...scale.description, notes, sourceFile: String(file), sourcePathHash: String(path_hash) },
    new Uint8Array(voxels.buffer),
  );
  expect(local.report.contentId).toBe(contentId);
});

test("absent chunks are counted; faults name the path", async () => {
  const path = join(folder, "faults");
  await writeArray(join(path, "a.zarr"), plainZarr);
  const files = filesIn(path);
  const address = addressOfFolder("a.zarr");
  const image = await openImage(address, files);
  const [scale] = image.scales as [ZarrScale];
  files.delete(relative(path, join(path, "a.zarr/1.1.1")));
  expect((await voxelsOf(address, scale, files)).absent).toBe(1);
  await expect(openImage(addressOfFolder("a.zarr/none"), files)).rejects.toThrow(
    "a.zarr/none: expected zarr.json, .zarray or .zgroup, found none of them",
  );
  files.set("a.zarr/.zarray", new Blob(["{"]));
  await expect(openImage(address, files)).rejects.toThrow("a.zarr: its metadata are not valid");
  files.set("a.zarr/.zarray", new Blob([new Uint8Array((16 << 20) + 1)]));
  await expect(openImage(address, files)).rejects.toThrow(
    "a.zarr/.zarray: expected at most 16777216 bytes, found 16777217",
  );
});
