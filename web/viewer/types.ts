import { maxIsosurfaces } from "../../build/wasm/web/layouts.js";
import type { Triple } from "../stream/types.ts";

/** A view of the volume; the numbers of shared/render/camera.h. Angles in degrees. */
export interface Camera {
  /** World: what the camera looks at, and orbits. */
  target: Triple;
  /** From the eye to the target, world units. */
  distance: number;
  /** 0: the eye is in front (−y); 90: at +x. */
  azimuth: number;
  /** −90 … 90; 90: the eye is above (+z). */
  elevation: number;
  roll: number;
  /** Vertical. */
  fieldOfView: number;
}

/** One isosurface: isovalue in the volume's values, colour as #rrggbb (sRGB), opacity 0 … 1. */
export interface Surface {
  isovalue: number;
  colour: string;
  opacity: number;
}

/** The largest number of isosurfaces; more are ignored (kMaxIsosurfaces in shared/render/renderer.h). */
export const maxSurfaces: number = maxIsosurfaces;

export const splatKinds = ["quad", "ellipse", "blended", "exact"] as const;
/** What a sample is drawn as (shared/render/renderer.h, SplatKind). */
export type SplatKind = (typeof splatKinds)[number];

export const colourings = [
  "isosurface",
  "isovalue",
  "gradient",
  "depth",
  "level",
  "projection-error",
] as const;
/** What decides a pixel's colour (shared/render/renderer.h, ColourBy). */
export type Colouring = (typeof colourings)[number];

export const colourMaps = ["viridis", "magma", "cividis", "turbo"] as const;
export type ColourMap = (typeof colourMaps)[number];

/** How the surfaces look. */
export interface Look {
  /** automatic: fast splats while something moves, exact ones when it rests. */
  kind: SplatKind | "automatic";
  colourBy: Colouring;
  colourMap: ColourMap;
  /** #rrggbb, sRGB. */
  background: string;
  /** Strength of eye-dome lighting, 0 … 1. */
  eyeDome: number;
}

/** What colours stand for (shared/render/splat_passes.cpp, scalar_weights). */
export interface Legend {
  colourBy: Exclude<Colouring, "isosurface">;
  /** CSS colours, evenly spaced from low to high. */
  colours: readonly string[];
  /** What the first and the last colour stand for; null: the nearest and farthest of the view. */
  range: readonly [number, number] | null;
}

/** Keeps the side that the normal points to: normal · world ≥ offset. */
export interface ClipPlane {
  normal: Triple;
  offset: number;
}

/** The part of the volume that is shown: what is in the box and on the right side of every plane. */
export interface Clip {
  /** The box: fractions of the volume's extent along x, y, z. */
  low: Triple;
  high: Triple;
  /** At most `maxClipPlanes`; more are ignored. */
  planes: readonly ClipPlane[];
}

/** What was drawn last. */
export interface FrameReport {
  samplesDrawn: number;
  samplesResident: number;
  gpuBytes: number;
  kind: SplatKind;
  /** Frames per second while frames follow one another; 0 when the view stands still. */
  framesPerSecond: number;
}

export const defaultLook: Look = {
  kind: "automatic",
  colourBy: "isosurface",
  colourMap: "viridis",
  background: "#ffffff",
  eyeDome: 0.5,
};
