import type { Triple } from "../core/types.ts";
import {
  type MeasuredField,
  type MeasuredPoint,
  type Measurement,
  measurementKinds,
  mostMeasurements,
  mostPointsInAll,
  pointCounts,
} from "../measure/measurement.ts";
import { defaultLight, type Light, lightRanges } from "../viewer/light.ts";
import { noSlices } from "../viewer/slices.ts";
import {
  type Clip,
  type ClipPlane,
  colourings,
  colourMaps,
  type FieldLook,
  fieldScales,
  type Slices,
  shadings,
  splatKinds,
} from "../viewer/types.ts";
import { type Member, optional } from "./member.ts";
import {
  type CameraDocument,
  type LookDocument,
  lightMembers,
  maxFieldNameBytes,
  maxFieldSteps,
  maxScenePlanes,
  type SceneDocument,
} from "./scene_document.ts";

type PictureDocument = Pick<
  SceneDocument,
  "camera" | "clip" | "slices" | "look" | "background" | "measurements"
>;

/** Reads camera, clipping, slices, look, background and measurements. Throws the errors of parseScene. */
export function readPicture(root: Member): PictureDocument {
  return {
    camera: optional(root.at("camera"), readCamera, null),
    clip: readClip(root.at("clip")),
    slices: optional(root.at("slices"), readSlices, noSlices),
    look: optional(root.at("look"), readLook, {}),
    background: optional(root.at("background"), (colour) => colour.colour(true), null),
    measurements: optional(root.at("measurements"), readMeasurements, []),
  };
}

function readCamera(camera: Member): CameraDocument {
  const angle = (key: string, otherwise: number, least: number, most: number) =>
    optional(camera.at(key), (found) => found.number(least, most), otherwise);
  return {
    target: camera.at("target").vector(),
    distance: camera.at("distance").number(1e-300),
    azimuth: angle("azimuth", 30, -1e6, 1e6),
    elevation: angle("elevation", 20, -90, 90),
    roll: angle("roll", 0, -1e6, 1e6),
    fieldOfView: angle("field_of_view", 30, 1, 120),
    isOrthographic: optional(camera.at("orthographic"), (found) => found.flag(), false),
  };
}

function readClip(clip: Member): Required<Clip> {
  const box = clip.at("box");
  return {
    low: box.exists ? box.at("low").vector(0, 1) : [0, 0, 0],
    high: box.exists ? box.at("high").vector(0, 1) : [1, 1, 1],
    planes: optional(clip.at("planes"), (list) => list.list(0, maxScenePlanes), []).map(readPlane),
    caps: optional(clip.at("caps"), (caps) => caps.flag(), false),
  };
}

function readPlane(plane: Member): ClipPlane {
  const normal = plane.at("normal").vector(-1e9, 1e9);
  const offset = plane.at("offset").number();
  if (!(Math.hypot(...normal) > 0)) plane.at("normal").refuse("a normal that is not 0");
  return { normal, offset };
}

function readSlices(slices: Member): Slices {
  slices.requireObject("slices");
  const along = optional(slices.at("along"), (list) => list.list(3, 3), []);
  const share = (axis: number) => {
    const found = along[axis];
    return found?.exists ? found.number(0, 1) : null;
  };
  const read: Slices = { along: [share(0), share(1), share(2)] };
  const plane = optional(slices.at("plane"), readPlane, undefined);
  const range = optional(slices.at("range"), readRange, undefined);
  const mapped = optional(slices.at("mapped"), (it) => it.flag(), false);
  return {
    ...read,
    ...(plane && { plane }),
    ...(range && { range }),
    ...(mapped && { mapped }),
  };
}

function readRange(range: Member): [number, number] {
  const [low, high] = range.list(2, 2) as [Member, Member];
  const values: [number, number] = [low.number(), high.number()];
  if (!(values[0] < values[1])) high.refuse("a number above the first");
  return values;
}

function readLook(look: Member): LookDocument {
  look.requireObject("a look");
  const read: LookDocument = {};
  const kind = optional(
    look.at("kind"),
    (it) => it.oneOf(["automatic", ...splatKinds] as const),
    undefined,
  );
  if (kind) read.kind = kind;
  const shading = optional(look.at("shading"), (it) => it.oneOf(shadings), undefined);
  if (shading) read.shading = shading;
  const colourBy = optional(look.at("colour_by"), (it) => it.oneOf(colourings), undefined);
  if (colourBy) read.colourBy = colourBy;
  const colourMap = optional(look.at("colour_map"), (it) => it.oneOf(colourMaps), undefined);
  if (colourMap) read.colourMap = colourMap;
  const field = optional(look.at("field"), readField, undefined);
  if (field) read.field = field;
  if (colourBy === "field" && !field) look.at("field").refuse("the field that colours show");
  const light = optional(look.at("light"), readLight, undefined);
  if (light) read.light = light;
  const eyeDome = optional(look.at("eye_dome"), (it) => it.number(0, 1), undefined);
  if (eyeDome !== undefined) read.eyeDome = eyeDome;
  return read;
}

function readField(field: Member): FieldLook {
  field.requireObject("a field");
  const name = field.at("name").text(maxFieldNameBytes);
  if (name === "") field.at("name").refuse("the name of a field");
  const scale = optional(field.at("scale"), (it) => it.oneOf(fieldScales), "linear");
  const range = optional(field.at("range"), readRange, null);
  if (range && scale === "logarithmic" && !(range[0] > 0)) {
    const [low] = field.at("range").list(2, 2) as [Member, Member];
    low.refuse("a number above 0, for a logarithmic scale");
  }
  const steps = optional(field.at("steps"), (it) => it.integer(0), 0);
  if (steps === 1 || steps > maxFieldSteps) {
    field.at("steps").refuse(`0, or 2 to ${maxFieldSteps} colours`);
  }
  const lines = optional(field.at("lines"), (it) => it.number(), 0);
  if (lines < 0) field.at("lines").refuse("0, or a number above 0");
  return { name, range, scale, steps, lines };
}

function readLight(light: Member): Light {
  light.requireObject("a light");
  const read = { ...defaultLight };
  for (const [name, member] of lightMembers) {
    const found = light.at(member);
    if (found.exists) read[name] = found.number(...lightRanges[name]);
  }
  return read;
}

function readMeasurements(list: Member): Measurement[] {
  const measurements = list.list(0, mostMeasurements).map(readMeasurement);
  const points = measurements.reduce((sum, { points }) => sum + points.length, 0);
  if (points > mostPointsInAll) list.refuse(`at most ${mostPointsInAll} points in all`);
  return measurements;
}

function readMeasurement(measurement: Member): Measurement {
  const kind = measurement.at("kind").oneOf(measurementKinds);
  const points = measurement
    .at("points")
    .list(...pointCounts[kind])
    .map(readPoint);
  const text = optional(measurement.at("text"), (it) => it.text(), "");
  if (kind === "note" && text === "") measurement.at("text").refuse("the text of the note");
  return { kind, points, ...(text && { text }) };
}

function readPoint(point: Member): MeasuredPoint {
  const vector = (key: string): Triple | undefined =>
    optional(point.at(key), (it) => it.vector(), undefined);
  const position = point.at("position").vector();
  const value = optional(point.at("value"), (it) => it.number(), undefined);
  const normal = vector("normal");
  const level = optional(point.at("level"), (it) => it.integer(0), undefined);
  const layer = optional(point.at("layer"), (it) => it.text(), undefined);
  const voxel = vector("voxel");
  const field = optional(point.at("field"), readMeasuredField, undefined);
  return {
    position,
    ...(value !== undefined && { value }),
    ...(normal && { normal }),
    ...(level !== undefined && { level }),
    ...(layer !== undefined && { layer }),
    ...(voxel && { voxel }),
    ...(field && { field }),
  };
}

function readMeasuredField(field: Member): MeasuredField {
  field.requireObject("a field");
  const name = field.at("name").text();
  const value = field.at("value").number();
  const units = optional(field.at("units"), (it) => it.text(), undefined);
  return { name, value, ...(units !== undefined && { units }) };
}
