import type { Triple } from "../core/types.ts";

/** Scenes as documents (shared/core/scene/SCENE.md), with the defaults of absent members. */
export interface SceneDocument {
  name: string;
  layers: readonly LayerDocument[];
  /** Null: the scene does not change with time. */
  time: TimeDocument | null;
  camera: CameraDocument | null;
  clip: ClipDocument;
  /** #rrggbb or #rrggbbaa. */
  background: string | null;
  /** The document as it was read, with the members that are unknown here. */
  json: JsonObject;
}

export type JsonObject = { readonly [member: string]: unknown };

export interface LayerDocument {
  name: string;
  group: string;
  /** One, or one for each step: paths or addresses relative to the scene. */
  stores: readonly string[];
  /** Empty: viewers choose one. */
  surfaces: readonly SurfaceDocument[];
  visible: boolean;
  /** 4 × 4, row by row. */
  transform: readonly number[] | null;
}

export interface SurfaceDocument {
  isovalue: number;
  /** #rrggbb; null: viewers choose one. */
  colour: string | null;
  opacity: number;
}

export interface TimeDocument {
  /** Ascending, one for each step. */
  values: readonly number[];
  unit: string;
}

/** World, and degrees. */
export interface CameraDocument {
  target: Triple;
  distance: number;
  azimuth: number;
  elevation: number;
  roll: number;
  fieldOfView: number;
  isOrthographic: boolean;
}

export interface ClipDocument {
  /** Fractions of the extent of the first layer's volume. */
  low: Triple;
  high: Triple;
  planes: readonly { normal: Triple; offset: number }[];
  caps: boolean;
}

/** The limits of shared/core/scene/scene.h. */
export const maxSceneBytes = 4 * 1024 * 1024;
export const maxLayers = 4096;
export const maxSurfacesOfLayer = 8;
export const maxSteps = 65536;
export const maxScenePlanes = 6;
