/**
 * Pictures of a view by other programs, with the same camera and colours, but the light of each
 * program.
 */
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Browser } from "@playwright/test";
import { build } from "vite";
import type { Bench } from "../harness/benchmark.ts";
import { type RawVolume, readNrrd } from "../harness/flying_edges.ts";
import { root } from "../harness/paths.ts";
import { background, colour, eyeAndUp, fieldOfView, size, type View } from "./views.ts";

/** A view and its volume, in the form that the peers read. */
export interface PeerScene {
  view: View;
  volume: RawVolume;
  spacing: number[];
  /** The file with the values. */
  raw: string;
}

export function peerScene(bench: Bench, view: View, path: string): PeerScene {
  const header = readFileSync(path).subarray(0, 4096).toString("latin1");
  const spacing = header.match(/^spacings:[ \t]*(.*?)\r?$/m)?.[1] ?? "1 1 1";
  const volume = readNrrd(path);
  const raw = join(bench.folder, "volume.raw");
  writeFileSync(raw, volume.data);
  return { view, volume, spacing: spacing.split(/\s+/).map(Number), raw };
}

/** VTK's pictures, without and with ambient occlusion; undefined if they were skipped. */
export async function drawVtk(
  bench: Bench,
  { view, volume, spacing, raw }: PeerScene,
): Promise<{ plain: string; occluded: string } | undefined> {
  const python = bench.pythonWithVtk();
  const display = bench.program("xvfb-run");
  if (!python || !display) return undefined;
  const { eye, up } = eyeAndUp(view.camera);
  const plain = join(bench.folder, "vtk.png");
  const occluded = join(bench.folder, "vtk_occluded.png");
  const script = join(root, "tests/evidence/peers/vtk_picture.py");
  const numbers = [...eye, ...view.camera.target, ...up];
  await bench.command(display, [
    ...["-a", python, script, raw, ...volume.voxels.map(String), volume.type],
    ...[...spacing, view.isovalue, size.width, size.height].map(String),
    ...[colour, background, fieldOfView, ...numbers, plain, occluded].map(String),
  ]);
  return { plain, occluded };
}

/** Pages with vtk.js and NiiVue. */
export class BrowserPeers {
  readonly #files: string;
  readonly #browser: Browser;

  private constructor(files: string, browser: Browser) {
    this.#files = files;
    this.#browser = browser;
  }

  /** Builds the pages. Undefined if they were skipped. */
  static async create(bench: Bench, browser: Browser): Promise<BrowserPeers | undefined> {
    const peers = join(root, "tests/evidence/peers");
    if (!existsSync(join(peers, "node_modules"))) {
      bench.skip("vtk.js and NiiVue", "not installed (npm ci --prefix tests/evidence/peers)");
      return undefined;
    }
    const outDir = join(bench.folder, "peers");
    await build({
      root: join(peers, "pictures"),
      configFile: false,
      logLevel: "error",
      build: { outDir, target: "es2022" },
    });
    return new BrowserPeers(outDir, browser);
  }

  /** Draws the view; returns a PNG. */
  async draw(program: "vtk_js" | "niivue", scene: PeerScene): Promise<Buffer> {
    const page = await this.#browser.newPage({ viewport: size });
    page.setDefaultTimeout(300_000);
    try {
      await page.route("**/*", (route) => {
        const path = new URL(route.request().url()).pathname;
        if (path === "/volume.raw") return route.fulfill({ path: scene.raw });
        return route.fulfill({ path: join(this.#files, path === "/" ? "index.html" : path) });
      });
      await page.addInitScript((data) => Object.assign(window, { scene: data }), {
        program,
        ...sceneOf(scene),
      });
      await page.goto("http://peer.localhost/");
      await page.waitForFunction(() => performance.getEntriesByName("picture").length > 0);
      return await page.screenshot();
    } finally {
      await page.close();
    }
  }
}

/** The scene that the pages of tests/evidence/peers/pictures read. */
function sceneOf({ view, volume, spacing }: PeerScene) {
  const rgb = (text: string) =>
    [0, 2, 4].map((at) => Number.parseInt(text.slice(at, at + 2), 16) / 255);
  const { azimuth, elevation, distance, target } = view.camera;
  // NiiVue fits the longest side of the volume into the height of a view of scale 1.
  const longest = Math.max(...volume.voxels.map((n, axis) => n * (spacing[axis] ?? 1)));
  const shown = 2 * distance * Math.tan((fieldOfView * Math.PI) / 360);
  return {
    file: "volume.raw",
    voxels: volume.voxels,
    spacing,
    isovalue: view.isovalue,
    colour: rgb(colour),
    background: rgb(background),
    fieldOfView,
    target,
    ...eyeAndUp(view.camera),
    niivue: { azimuth: 360 - azimuth, elevation, scale: (1.12 * longest) / shown },
  };
}
