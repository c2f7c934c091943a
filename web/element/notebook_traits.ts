/** The traits of the notebook widget: names, defaults, and accepted values. */
import type { Triple } from "../core/types.ts";
import { readColour, readProjection } from "../viewer/setting_text.ts";
import { checkedTransform, type Transform } from "../viewer/transform.ts";
import type { Camera, Clip, Label, Slices, Surface } from "../viewer/types.ts";
import { readParts, shownParts } from "./overlay_area.ts";

/** A point of a surface that was clicked. */
export interface PickedPoint {
  /** World coordinates. */
  position: Triple;
  /** The same in voxels of the volume. */
  voxel: Triple;
  /** World, of unit length, towards the eye. */
  normal: Triple;
  isovalue: number;
  /** The name of its layer; empty if it has none. */
  layer: string;
  /** The label that the layer shows; null: none. */
  label: Label | null;
}

/** The open volume. */
export interface VolumeTrait {
  voxels: Triple;
  spacing: Triple;
  origin: Triple;
  /** The smallest and largest value. */
  range: readonly [number, number];
  suggested_isovalues: readonly number[];
}

/** The steps of the open scene. */
export interface TimeTrait {
  values: readonly number[];
  unit: string;
}

/** A further volume in the picture: a child element. */
export interface LayerTrait {
  /** The attribute `src` of the element `<isosplat-layer>`. */
  src: string;
  name?: string;
  group?: string;
  /** Default: one surface at the volume's first suggested isovalue. */
  surfaces?: readonly Surface[];
  visible?: boolean;
  /** 16 numbers, row by row. */
  transform?: Transform;
}

export interface Traits {
  /** The attribute `src` of the element. */
  src: string;
  /** As the attribute of the element: the address of a scene, which is shown instead of `src`. */
  scene: string;
  /** The step that is shown, of a scene that changes with time. Null: its first one. */
  step: number | null;
  /** Further volumes in the picture. Only the program changes them. */
  layers: readonly LayerTrait[];
  /** The isovalue of the first surface. Null: the volume's first suggestion. */
  isovalue: number | null;
  /** All surfaces. If empty, there is one surface at `isovalue`. */
  surfaces: readonly Surface[];
  /** Null shows the whole volume. Properties that a camera from the program lacks do not change. */
  camera: Camera | null;
  /** Null: nothing is cut off. */
  clip: Clip | null;
  /** Null: none. */
  slices: Slices | null;
  /** As the attribute of the element; empty: white. */
  background: string;
  controls: boolean;
  /** As the attribute of the element: the overlays above the picture. */
  show: string;
  /** As the attribute of the element: widgets of a group have the same view. */
  link: string;
  /** A length of CSS. Empty: three quarters of the width. */
  height: string;

  /** The state of streaming, as `Progress.state`; empty before the first. */
  state: string;
  /** Whether everything visible is drawn at the level that the view resolves. */
  complete: boolean;
  /** The message of the present fault; empty if there is none. */
  fault: string;
  volume: VolumeTrait | null;
  /** Null: the picture does not change with time. */
  time: TimeTrait | null;
  picked: PickedPoint | null;
}

export type TraitName = keyof Traits;

/** The Python class has the same defaults (tests/web/notebook.spec.ts). */
export const traitDefaults: Readonly<Traits> = {
  src: "",
  scene: "",
  step: null,
  layers: [],
  isovalue: null,
  surfaces: [],
  camera: null,
  clip: null,
  slices: null,
  background: "",
  controls: true,
  show: "",
  link: "",
  height: "",
  state: "",
  complete: false,
  fault: "",
  volume: null,
  time: null,
  picked: null,
};

/** Traits that only the widget sets. */
export const reportedTraits: readonly TraitName[] = [
  "state",
  "complete",
  "fault",
  "volume",
  "time",
  "picked",
];

const isObject = (value: unknown): value is Record<string, unknown> =>
  typeof value === "object" && value !== null && !Array.isArray(value);

const isNumber = (value: unknown): value is number => Number.isFinite(value);

const isTriple = (value: unknown): value is Triple =>
  Array.isArray(value) && value.length === 3 && value.every(isNumber);

/**
 * Values come from a program. These functions throw an Error with the trait, the expected and the
 * found value.
 */
function wrong(name: TraitName, found: unknown, expected: string): Error {
  const text = JSON.stringify(found) ?? String(found);
  return new Error(`${name}: expected ${expected}, found ${text.slice(0, 100)}`);
}

export function textOf(name: TraitName, value: unknown): string {
  if (value === null || value === undefined) return "";
  if (typeof value !== "string") throw wrong(name, value, "a text");
  return value;
}

export function backgroundOf(value: unknown): string {
  const text = textOf("background", value);
  if (text && !readColour(text)) throw wrong("background", text, "a colour as rrggbb");
  return text;
}

export function showOf(value: unknown): string {
  const text = textOf("show", value);
  if (!readParts(text)) throw wrong("show", text, `some of ${shownParts.join(",")}`);
  return text;
}

export function isovalueOf(value: unknown): number | null {
  if (value === null || value === undefined) return null;
  if (!isNumber(value)) throw wrong("isovalue", value, "a finite number");
  return value;
}

export function surfacesOf(value: unknown): Surface[] {
  const expected = "a list of { isovalue, colour: #rrggbb, opacity: 0 to 1 }";
  if (value === null || value === undefined) return [];
  if (!Array.isArray(value)) throw wrong("surfaces", value, expected);
  return value.map((surface: unknown) => {
    if (!isObject(surface)) throw wrong("surfaces", surface, expected);
    const { isovalue, colour, opacity = 1 } = surface;
    const read = typeof colour === "string" ? readColour(colour) : undefined;
    const isOpacity = isNumber(opacity) && opacity >= 0 && opacity <= 1;
    if (!isNumber(isovalue) || !read || !isOpacity) throw wrong("surfaces", surface, expected);
    return { isovalue, colour: read, opacity };
  });
}

export function stepOf(value: unknown): number | null {
  if (value === null || value === undefined) return null;
  if (!Number.isInteger(value) || (value as number) < 0) {
    throw wrong("step", value, "a whole number from 0");
  }
  return value as number;
}

export function layersOf(value: unknown): LayerTrait[] {
  const expected =
    "a list of { src, name, group, surfaces as the trait, visible, transform: 16 numbers row by row }";
  if (value === null || value === undefined) return [];
  if (!Array.isArray(value)) throw wrong("layers", value, expected);
  return value.map((layer: unknown) => {
    if (!isObject(layer)) throw wrong("layers", layer, expected);
    const { src, name = "", group = "", visible = true, surfaces, transform } = layer;
    const areTexts = [src, name, group].every((text) => typeof text === "string");
    if (!areTexts || src === "" || typeof visible !== "boolean") {
      throw wrong("layers", layer, expected);
    }
    try {
      return {
        ...({ src, name, group, visible } as LayerTrait),
        ...(surfaces != null && { surfaces: surfacesOf(surfaces) }),
        ...(transform != null && { transform: checkedTransform(transform as Transform) }),
      };
    } catch {
      throw wrong("layers", layer, expected);
    }
  });
}

const cameraNumbers = ["distance", "azimuth", "elevation", "roll", "fieldOfView"] as const;

/** `present` supplies properties that the value lacks. */
export function cameraOf(value: unknown, present: Camera | null): Camera | null {
  if (value === null || value === undefined) return null;
  const expected = `{ target: [x, y, z], ${cameraNumbers.join(", ")}, projection }`;
  if (!isObject(value)) throw wrong("camera", value, expected);
  const camera: Record<string, unknown> = { ...present, ...value };
  const { target, projection = "perspective" } = camera;
  const isProjection = typeof projection === "string" && readProjection(projection) === projection;
  if (
    !isTriple(target) ||
    !isProjection ||
    !cameraNumbers.every((name) => isNumber(camera[name]))
  ) {
    throw wrong("camera", value, expected);
  }
  const numbers = Object.fromEntries(cameraNumbers.map((name) => [name, camera[name]]));
  return { target, projection, ...numbers } as unknown as Camera;
}

/** An oblique plane in the form of a program; undefined if the value is not a plane. */
function planeOf(value: unknown): Clip["planes"][number] | undefined {
  if (!isObject(value) || !isTriple(value.normal) || !isNumber(value.offset)) return undefined;
  return { normal: value.normal, offset: value.offset };
}

export function clipOf(value: unknown): Clip | null {
  if (value === null || value === undefined) return null;
  const expected = "{ low: [x, y, z], high: [x, y, z], planes: [{ normal, offset }], caps }";
  if (!isObject(value)) throw wrong("clip", value, expected);
  const { low, high, planes = [], caps = false } = value;
  const isBox = isTriple(low) && isTriple(high);
  if (!isBox || !Array.isArray(planes) || typeof caps !== "boolean") {
    throw wrong("clip", value, expected);
  }
  return {
    low,
    high,
    planes: planes.map((plane: unknown) => {
      const read = planeOf(plane);
      if (!read) throw wrong("clip", plane, expected);
      return read;
    }),
    ...(caps && { caps }),
  };
}

const isShare = (value: unknown) => value === null || (isNumber(value) && value >= 0 && value <= 1);

const isShares = (value: unknown): value is Slices["along"] =>
  Array.isArray(value) && value.length === 3 && value.every(isShare);

function isRange(value: unknown): value is NonNullable<Slices["range"]> {
  const [low, high, ...more] = Array.isArray(value) ? value : [];
  return isNumber(low) && isNumber(high) && low < high && more.length === 0;
}

export function slicesOf(value: unknown): Slices | null {
  if (value === null || value === undefined) return null;
  const expected =
    "{ along: [x, y, z] as 0 to 1 or null, plane: { normal, offset }, range: [black, white] }";
  if (!isObject(value)) throw wrong("slices", value, expected);
  const along = value.along ?? [null, null, null];
  // None in Python is null.
  const range = value.range ?? undefined;
  const plane = planeOf(value.plane);
  const isPlane = plane?.normal.some((part) => part !== 0) ?? value.plane == null;
  if (!isShares(along) || !isPlane || !(range === undefined || isRange(range))) {
    throw wrong("slices", value, expected);
  }
  return { along, ...(plane && { plane }), ...(range && { range }) };
}
