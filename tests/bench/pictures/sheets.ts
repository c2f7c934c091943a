/** Sheets that compare each view of views.ts: Isosplat's kinds and shadings, VTK, vtk.js, NiiVue. */
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "@playwright/test";
import type { Bench } from "../harness/benchmark.ts";
import { root } from "../harness/paths.ts";
import { buildStore } from "../stream/serving.ts";
import { launch } from "../stream/visit.ts";
import { BrowserPeers, drawVtk, type PeerScene, peerScene } from "./peers.ts";
import { background, colour, size, type View, views } from "./views.ts";

interface Picture {
  title: string;
  png: Buffer;
}

const kinds: [string, string, string][] = [
  ["exact", "smooth", "Isosplat: exact splats, smooth shading"],
  ["ellipse", "smooth", "Isosplat: ellipses, smooth shading"],
  ["quad", "smooth", "Isosplat: quads"],
  ["exact", "exact", "Isosplat: exact splats, exact shading"],
  ["ellipse", "exact", "Isosplat: ellipses, exact shading"],
];

async function drawOurs(bench: Bench, store: string, view: View): Promise<Picture[]> {
  const { azimuth, elevation, distance, target } = view.camera;
  const pictures: Picture[] = [];
  for (const [kind, shading, title] of kinds) {
    const output = join(bench.folder, "ours.png");
    await bench.command(bench.isosplat, [
      ...["render", store, "-i", String(view.isovalue), "--kind", kind, "--shading", shading],
      ...["--camera", [azimuth, elevation, distance, ...target].join(","), "--level", "0"],
      ...["--size", `${size.width}x${size.height}`, "--colour", colour],
      ...["--background", background, "-o", output, "--force"],
    ]);
    pictures.push({ title, png: readFileSync(output) });
  }
  return pictures;
}

async function drawPeers(
  bench: Bench,
  pages: BrowserPeers | undefined,
  scene: PeerScene,
): Promise<Picture[]> {
  const pictures: Picture[] = [];
  const vtk = await drawVtk(bench, scene);
  if (vtk) {
    pictures.push({ title: "VTK: Flying Edges, SSAO", png: readFileSync(vtk.occluded) });
    pictures.push({ title: "VTK: Flying Edges", png: readFileSync(vtk.plain) });
  }
  if (pages) {
    pictures.push({ title: "vtk.js: marching cubes", png: await pages.draw("vtk_js", scene) });
    pictures.push({ title: "NiiVue: volume renderer", png: await pages.draw("niivue", scene) });
  }
  return pictures;
}

/** One JPEG of all pictures, three in a row, with their titles. */
async function compose(browser: Browser, pictures: Picture[]): Promise<Buffer> {
  const figures = pictures.map(
    ({ title, png }) =>
      `<figure><img src="data:image/png;base64,${png.toString("base64")}"><figcaption>${title}</figcaption></figure>`,
  );
  const page = await browser.newPage({ viewport: { width: 3 * size.width, height: 100 } });
  try {
    await page.setContent(`<style>
      body { margin: 0; display: grid; grid-template-columns: repeat(3, 1fr); background: white; }
      figure { margin: 0; width: ${size.width}px }
      img { display: block; width: ${size.width}px; height: ${size.height}px }
      figcaption { font: 15px/24px sans-serif; text-align: center }
    </style>${figures.join("")}`);
    return await page.screenshot({ fullPage: true, type: "jpeg", quality: 82 });
  } finally {
    await page.close();
  }
}

/** Draws the sheets whose names match into docs/pictures. */
export async function drawSheets(bench: Bench, wanted: RegExp): Promise<void> {
  const browser = await launch();
  try {
    const pages = await BrowserPeers.create(bench, browser);
    const stores = new Map<string, string>();
    for (const view of views) {
      const volume = wanted.test(`compared_${view.name}`) && bench.volume(view.file);
      if (!volume) continue;
      const store = stores.get(view.file) ?? (await buildStore(bench, volume, view.file));
      stores.set(view.file, store);
      bench.say(view.title);
      const ours = await drawOurs(bench, store, view);
      const peers = await drawPeers(bench, pages, peerScene(bench, view, volume));
      const [best, ...others] = ours;
      const [first, ...rest] = peers;
      // The first row compares the best of each.
      const pictures = [best, first, ...rest, ...others].filter((picture) => picture !== undefined);
      const sheet = await compose(browser, pictures);
      writeFileSync(join(root, `docs/pictures/compared_${view.name}.jpg`), sheet);
    }
  } finally {
    await browser.close();
  }
}
