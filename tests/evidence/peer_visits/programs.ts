/** The programs that show one volume of bytes, each on a separate server. */
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import type { Bench } from "../../bench/harness/benchmark.ts";
import { type RawVolume, readNrrd } from "../../bench/harness/flying_edges.ts";
import { nifti } from "../../bench/harness/nifti.ts";
import { omeZarr } from "../../bench/harness/ome_zarr.ts";
import { flyingEdgesMesh, spacingOf } from "../../bench/harness/render.ts";
import { buildStore, serve } from "../../bench/stream/serving.ts";
import type { Visitor } from "../../bench/stream/visit.ts";
import { servePeer } from "../../bench/stream/vtk_js.ts";
import { type PeerSite, servePage } from "./serve_page.ts";
import type { Program } from "./visit_peer.ts";

export interface Surface {
  /** An NRRD header of bytes; its data is another file. */
  volume: string;
  name: string;
  isovalue: number;
  /** The isovalue after the change. */
  next: number;
}

/** The size of the view in Isosplat's page of 1024 × 768. */
const viewport = { width: 688, height: 716 };

/** Sets the page's slider, whose ends are the smallest and the largest byte. */
async function prepareIsosplat(visitor: Visitor): Promise<void> {
  await visitor.controls();
  await visitor.page.evaluate(() => {
    Object.assign(globalThis, {
      changeIsovalue(isovalue: number) {
        const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
        if (!slider) throw new Error("the page has no isovalue slider");
        slider.valueAsNumber =
          Number(slider.min) + (isovalue / 255) * (Number(slider.max) - Number(slider.min));
        slider.dispatchEvent(new Event("input", { bubbles: true }));
      },
    });
  });
}

async function isosplat(bench: Bench, { volume, name, isovalue }: Surface): Promise<Program> {
  const url = await serve(bench, [await buildStore(bench, volume, name)]);
  return {
    name: `Isosplat ${versionIn(bench.root)}`,
    url: `${url}?volume=${name}&isovalue=${isovalue}`,
    first: "isosplat:surface",
    final: "isosplat:complete",
    viewport: { width: 1024, height: 768 },
    prepare: prepareIsosplat,
    refines: true,
  };
}

const versionIn = (folder: string): string =>
  (JSON.parse(readFileSync(join(folder, "package.json"), "utf8")) as { version: string }).version;

/** "three.js 0.1.2", with the version that is installed. */
const named = (bench: Bench, title: string, dependency: string): string =>
  `${title} ${versionIn(join(bench.root, "tests/evidence/peers/node_modules", dependency))}`;

/** A compressed mesh of an isovalue, made by Flying Edges, or by Isosplat if VTK is missing. */
async function compressedMesh(bench: Bench, { volume, name }: Surface, isovalue: number) {
  const store = join(bench.folder, `${name}.isosplat`);
  const byVtk = await flyingEdgesMesh(bench, volume, isovalue);
  const mesh = byVtk ?? join(bench.folder, `${isovalue}.source.glb`);
  if (!byVtk) {
    const output = ["-i", String(isovalue), "-o", mesh, "--force"];
    await bench.command(bench.isosplat, ["extract", store, "--mesh", ...output]);
  }
  const compressed = join(bench.folder, `${isovalue}.glb`);
  const script = join(bench.root, "tests/evidence/peers/gltf/compress.js");
  await bench.command(process.execPath, [script, mesh, compressed]);
  return { content: readFileSync(compressed), source: byVtk ? "Flying Edges" : "Isosplat" };
}

/** All programs that can be served, and a function that ends their servers. */
export async function programsFor(
  bench: Bench,
  surface: Surface,
): Promise<{ programs: Program[]; close: () => void }> {
  const { volume, name, isovalue, next } = surface;
  const programs = [await isosplat(bench, surface)];
  const sites: PeerSite[] = [];
  const add = (
    site: PeerSite | undefined,
    title: () => string,
    query: string,
    first: string,
    final = first,
  ) => {
    if (!site) return;
    sites.push(site);
    programs.push({ name: title(), url: `${site.url}?${query}`, first, final, viewport });
  };
  const raw: RawVolume = readNrrd(volume);
  const spacing = spacingOf(volume).map(Number);
  const three = (title: string) => named(bench, `${title}, three.js`, "three");

  const vtk = await servePeer(bench, volume);
  const asked = `isovalue=${isovalue}`;
  add(vtk, () => named(bench, "vtk.js", "@kitware/vtk.js"), `${vtk?.query}&${asked}`, "vtk:image");

  const file = gzipSync(nifti(raw.voxels, spacing, raw.data), { level: 9 });
  const niivue = await servePage(bench, "drop", new Map([[`${name}.nii.gz`, file]]));
  const niivueName = () => named(bench, "NiiVue", "@niivue/niivue");
  add(niivue, niivueName, `volume=${name}.nii.gz&${asked}`, "peer:image");

  const caster = await servePeer(bench, volume, "three_volume");
  add(caster, () => three("ray caster"), `${caster?.query}&${asked}`, "peer:image");

  const zarr = await servePage(bench, "ome_zarr", omeZarr(name, raw.data, raw.voxels, spacing));
  const zarrName = () => three(`OME-Zarr, ${named(bench, "zarrita", "zarrita")}`);
  add(zarr, zarrName, `volume=${name}.zarr&${asked}`, "peer:image", "peer:final");

  const meshes = new Map<string, Buffer>();
  let source = "";
  const site = await servePage(bench, "gltf", meshes);
  for (const each of site ? [isovalue, next] : []) {
    const mesh = await compressedMesh(bench, surface, each);
    meshes.set(`${each}.glb`, mesh.content);
    source = mesh.source;
  }
  add(site, () => three(`glTF mesh by ${source}`), `mesh=${isovalue}.glb`, "peer:image");

  return {
    programs,
    close() {
      for (const { server } of sites) server.close();
    },
  };
}
