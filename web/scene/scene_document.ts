import type { Measurement } from "../measure/measurement.ts";
import type { Light } from "../viewer/light.ts";
import type { SceneTime } from "../viewer/time.ts";
import type { Camera, Clip, Label, Look, Slices } from "../viewer/types.ts";

/** Scenes as documents (shared/core/scene/SCENE.md), with the defaults of absent members. */
export interface SceneDocument {
  name: string;
  layers: readonly LayerDocument[];
  /** Null: the scene does not change with time. */
  time: Required<SceneTime> | null;
  /** The number of the step that is shown first. */
  step: number;
  camera: CameraDocument | null;
  clip: Required<Clip>;
  slices: Slices;
  look: LookDocument;
  /** #rrggbb or #rrggbbaa. */
  background: string | null;
  measurements: readonly Measurement[];
  /** The document as it was read, with the members that are unknown here. */
  json: JsonObject;
}

export type JsonObject = { readonly [member: string]: unknown };

export interface LayerDocument {
  name: string;
  group: string;
  /** The volume of which the layer shows a part; empty: none. */
  partOf: string;
  /** The path or address of the store, relative to the scene; with steps, that of each step's store. */
  stores: readonly string[];
  /** Empty: viewers choose one. */
  surfaces: readonly SurfaceDocument[];
  visible: boolean;
  /** 4 × 4, row by row. */
  transform: readonly number[] | null;
  label: Label | null;
}

export interface SurfaceDocument {
  isovalue: number;
  /** #rrggbb; null: viewers choose one. */
  colour: string | null;
  opacity: number;
}

export interface CameraDocument extends Omit<Camera, "projection"> {
  isOrthographic: boolean;
}

/** The settings of the look that a scene states. The background is a separate member. */
export type LookDocument = Partial<Omit<Look, "background">>;

/** The numbers of a light with the names of their members in the document. */
export const lightMembers: readonly (readonly [keyof Light, string])[] = [
  ["azimuth", "azimuth"],
  ["elevation", "elevation"],
  ["key", "key"],
  ["sky", "sky"],
  ["rim", "rim"],
  ["highlight", "highlight"],
  ["roughness", "roughness"],
  ["occlusion", "occlusion"],
  ["occlusionRadius", "occlusion_radius"],
  ["shadow", "shadow"],
  ["shadowSoftness", "shadow_softness"],
];

/** The limits of shared/core/scene/scene.h. */
export const maxSceneBytes = 4 * 1024 * 1024;
export const maxTextBytes = 1024;
export const maxLayers = 4096;
export const maxSurfacesOfLayer = 8;
export const maxSteps = 65536;
export const maxFieldNameBytes = 64;
export const maxFieldSteps = 256;
export const maxScenePlanes = 6;

/** The value if it is an object, else an empty one. */
export function objectOf(value: unknown): JsonObject {
  const isObject = typeof value === "object" && value !== null && !Array.isArray(value);
  return isObject ? (value as JsonObject) : {};
}
