/**
 * Compares the page's picture of a complete view with the native renderer's picture of every
 * sample.
 */
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import type { Page } from "@playwright/test";
import { type Comparison, comparePixels, decodePng } from "./pixels.ts";
import { program } from "./server.ts";
import { complete, savedPicture, settled } from "./view.ts";

/** Maximum share of the covered pixels that may differ. */
export const maxDiffering = 1e-4;

/** An isosurface of a real volume, and views at whose resolution level 0 is selected. */
export interface TrueCase {
  name: string;
  file: string;
  isovalue: number;
  /** Cameras as in the page's address, by name. */
  views: Record<string, string>;
}

export const trueCases: TrueCase[] = [
  {
    name: "aneurysm",
    file: "aneurysm.nhdr",
    isovalue: 150.5,
    views: {
      far: "37.2,22.4,800,127,127,127",
      near: "37.2,22.4,220,127,127,127",
    },
  },
  {
    name: "aneurysm",
    file: "aneurysm.nhdr",
    isovalue: 60.5,
    views: {
      aside: "10,60,300,127,127,127",
    },
  },
  {
    name: "bonsai",
    file: "bonsai.nhdr",
    isovalue: 71.5,
    views: {
      far: "37.2,22.4,800,127,127,127",
      near: "60,15,260,127,127,150",
    },
  },
  {
    name: "bonsai",
    file: "bonsai.nhdr",
    isovalue: 150.5,
    views: {
      aside: "30,-20,350,127,127,100",
    },
  },
  {
    name: "engine",
    file: "engine.nhdr",
    isovalue: 60.5,
    views: {
      far: "37.2,22.4,700,127,127,64",
      near: "37.2,22.4,250,127,127,64",
    },
  },
  {
    name: "lobster",
    file: "lobster.nhdr",
    isovalue: 40.5,
    views: {
      far: "37.2,42.4,800,150,160,40",
      near: "20,50,220,150,160,40",
    },
  },
  {
    name: "bunny_ct_i16",
    file: "bunny_ct_i16.nrrd",
    isovalue: 1000.5,
    views: {
      far: "37.2,22.4,400,86,86,90",
      near: "37.2,22.4,150,86,86,90",
    },
  },
  {
    name: "bunny_ct_i16",
    file: "bunny_ct_i16.nrrd",
    isovalue: 1500.5,
    views: {
      aside: "250,40,250,86,86,90",
    },
  },
  {
    name: "CT_AVM",
    file: "CT_AVM.nii.gz",
    isovalue: 300.5,
    views: {
      far: "37.2,22.4,650,-18.4,-17,12",
      near: "37.2,22.4,180,-18.4,-17,12",
    },
  },
  {
    name: "CT_AVM",
    file: "CT_AVM.nii.gz",
    isovalue: 220.5,
    views: {
      aside: "200,10,500,-18.4,-17,12",
    },
  },
  {
    name: "CT_AVM",
    file: "CT_AVM.nii.gz",
    isovalue: 60.5,
    views: {
      above: "110,55,420,-18.4,-17,12",
      below: "300,-35,330,-18.4,-17,12",
    },
  },
  {
    name: "CT_AVM",
    file: "CT_AVM.nii.gz",
    isovalue: 400.5,
    views: {
      above: "110,55,420,-18.4,-17,12",
      below: "300,-35,330,-18.4,-17,12",
    },
  },
  {
    name: "chris_t1",
    file: "chris_t1.nii.gz",
    isovalue: 70.5,
    views: {
      far: "37.2,22.4,700,1,6,7",
      near: "37.2,22.4,240,1,6,7",
    },
  },
  {
    name: "chris_t1",
    file: "chris_t1.nii.gz",
    isovalue: 150.5,
    views: {
      above: "110,55,450,1,6,7",
      below: "300,-35,330,1,6,7",
    },
  },
  {
    name: "chris_t1",
    file: "chris_t1.nii.gz",
    isovalue: 25.5,
    views: {
      above: "110,55,450,1,6,7",
      below: "300,-35,330,1,6,7",
    },
  },
];

/** Size of the panel and the status bar, in px. */
const besideCanvas = { width: 336, height: 52 };

export interface Size {
  width: number;
  height: number;
}

/** The page size that gives a canvas of this size. */
export function pageSize(canvas: Size): Size {
  return {
    width: canvas.width + besideCanvas.width,
    height: canvas.height + besideCanvas.height,
  };
}

/** The query of a case's page: drawn like `nativePicture`. */
export function queryOf({ name, isovalue }: TrueCase, camera: string): string {
  return `?volume=${name}&isovalue=${isovalue}&camera=${camera}&kind=exact&background=ffffff`;
}

/** Draws every sample of level 0. Returns a PNG. */
export function nativePicture(
  store: string,
  { isovalue }: TrueCase,
  camera: string,
  { width, height }: Size,
  output: string,
): Buffer {
  execFileSync(
    program,
    [
      ...["render", store, "--isovalue", String(isovalue), "--camera", camera, "-o", output],
      ...["--size", `${width}x${height}`, "--level", "0", "--samples", "1000000000"],
      ...["--kind", "exact", "--background", "ffffff", "--colour", "d9ccb3"],
    ],
    { stdio: "pipe" },
  );
  return readFileSync(output);
}

/** Waits until the page reports a complete view and a final picture. */
export async function completeAndSettled(page: Page, timeout = 120_000): Promise<void> {
  await complete(page, timeout);
  await settled(page, timeout);
  await complete(page, timeout);
}

/** Compares the picture that the page saves with the correct one. */
export async function differenceFrom(page: Page, truth: Buffer): Promise<Comparison> {
  const ours = await decodePng(page, await savedPicture(page));
  return comparePixels(ours, await decodePng(page, truth), 0xffffff);
}
