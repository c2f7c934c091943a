import type { Triple } from "../../core/types.ts";
import { type OverlayPart, overlayParts } from "../../overlay/parts.ts";
import { pageTexts } from "../../texts/page.ts";
import { isDefaultClip, isWhole, maxClipPlanes, wholeVolume } from "../../viewer/clipping.ts";
import { defaultLight, type Light } from "../../viewer/light.ts";
import {
  readBox,
  readCamera,
  readColour,
  readColours,
  readNumbers,
  readOpacities,
  readPlane,
  readProjection,
  readSlices,
  writeCamera,
  writeSlices,
} from "../../viewer/setting_text.ts";
import { isDefaultSlices, noSlices } from "../../viewer/slices.ts";
import {
  type Camera,
  type Clip,
  type Colouring,
  type ColourMap,
  colourings,
  colourMaps,
  type FieldLook,
  fieldScales,
  maxSurfaces,
  type Projection,
  projections,
  type Shading,
  type Slices,
  type SplatKind,
  shadings,
  splatKinds,
} from "../../viewer/types.ts";
import { type LayerAddress, readLayer, readOrder, writeLayer } from "./layer_address.ts";
import { expectedOfLight, lightParameters, readLight, writeLight } from "./light_address.ts";

/**
 * Queries longer than this (in letters) are not written: servers refuse addresses of more than
 * about 8 KiB.
 */
export const longestQuery = 7000;

/** The key in sessionStorage of the session that belongs to the address (open_session.ts). */
export const keptSessionKey = "isosplat-session";

/** Fainter surfaces look invisible; the panel's slider starts here. */
export const minOpacity = 0.05;

/**
 * The settings in the address. Missing settings have the page's defaults. Invalid settings are
 * treated as missing, so that an old or mistyped link still opens the volume; `notes` lists them.
 *
 *   volume=engine                  a volume of this server, or
 *   scene=head                     a scene of this server, or
 *   src=https://…/engine.isosplat  a store, or a scene (.isobundle, scene.json), on any host with Range
 *   src=device:CONTENT-ID          a store on this device; in a link that was copied, with
 *   file=head.nii.gz               the name of the volume, for whoever opens the link elsewhere
 *   spacing=0.5,0.5,1.2            distances between voxels in mm, for a volume whose file states none
 *   isovalue=60.5,180              one for each isosurface
 *   colour=d9ccb3,c65b4e  opacity=1,0.4
 *   camera=azimuth,elevation,distance,x,y,z[,roll[,field of view]]
 *   projection=orthographic        parallel rays
 *   kind=exact  shading=exact  colour-by=gradient  map=magma  background=ffffff  shade=0.5
 *   field=pressure  field-range=0,12.5  field-scale=logarithmic  field-steps=8  field-lines=0.5    with colour-by=field
 *   light=azimuth,elevation        of the key light, in degrees
 *   light-strength=key,sky,rim  material=highlight,roughness
 *   occlusion=strength,radius  shadow=strength,softness     see Light for the ranges
 *   clip=x0,x1,y0,y1,z0,z1         a box: fractions of the volume's extent; 0,1,0,1,0,1: nothing is clipped, even if the scene states a box
 *   measure=kind,x,y,z[,x,y,z …][|text]   once for each measurement: web/measure/measurement_text.ts; measure=none: hides those of the scene
 *   show=axes,scale,box            the overlays above the picture; none: nothing
 *   lang=de                        read by web/texts/language.ts, and kept on the device, not here
 *   plane=x,y,z,offset             once for each clip plane: keeps the side of its normal, see ClipPlane
 *   clip-caps=on                   closes the cut faces
 *   slices=0.5,,0.25               slices across x and z: fractions of the volume's extent; slices=none: hides those of the scene
 *   slice-plane=x,y,z,offset       an oblique slice, see SlicePlane
 *   time=12.5                      of a scene that changes with time: the value of its step
 *   slice-range=0,255              the values that are black and white in slices
 *   slice-colours=map              slices have the colours of the map instead of greys
 *   layer=volume:bone;isovalue:300 once for each further layer, and for changes of others: readLayer
 *   layer-order=1,0                the order of the layers in their list: readOrder
 */
export interface UrlState {
  volume?: string;
  scene?: string;
  src?: string;
  /** In links to volumes of a device alone. */
  file?: string;
  /** Ignored where the volume's file states its spacing. */
  spacing?: Triple;
  /** Not in addresses: the visitor has chosen `spacing`, or none, so that one kept on the device is not used. */
  isSpacingChosen?: boolean;
  isovalues?: number[];
  colours?: string[];
  opacities?: number[];
  /** Without `projection`, which may occur alone. */
  camera?: Camera;
  projection?: Projection;
  kind?: SplatKind | "automatic";
  shading?: Shading;
  colourBy?: Colouring;
  field?: FieldLook;
  colourMap?: ColourMap;
  background?: string;
  eyeDome?: number;
  light?: Light;
  clip?: Clip;
  slices?: Slices;
  layers?: readonly LayerAddress[];
  layerOrder?: readonly number[];
  /** In the unit of the scene. */
  time?: number;
  show?: ReadonlySet<OverlayPart>;
  /** One for each measurement, not validated: web/measure parses them. Empty: hides those of the scene. */
  measures?: readonly string[];
  /** Settings of the address that were ignored or changed: one sentence each, for the visitor. */
  notes?: string[];
}

/** The query with which this page was opened: that of its address, or the view that a single page was saved with. */
export function openedQuery(): string {
  const saved = document.querySelector<HTMLMetaElement>("meta[name=isosplat-view]");
  return location.search || (saved?.content ?? "");
}

function oneOf<T extends string>(text: string | null, values: readonly T[]): T | undefined {
  return values.find((value) => value === text);
}

function readClip(query: URLSearchParams): Clip | undefined {
  const box = readBox(query.get("clip"));
  const planes = query.getAll("plane").map(readPlane);
  const known = planes.filter((plane) => plane !== undefined).slice(0, maxClipPlanes);
  const caps = query.get("clip-caps") === "on";
  if (!box && known.length === 0 && !caps) return undefined;
  return { ...wholeVolume, ...box, planes: known, ...(caps && { caps }) };
}

function readShare(text: string): number | undefined {
  const n = readNumbers(text);
  const [share = Number.NaN] = n ?? [];
  return n?.length === 1 && share >= 0 && share <= 1 ? share : undefined;
}

function readNumber(text: string): number | undefined {
  const [number, ...more] = readNumbers(text) ?? [];
  return more.length === 0 ? number : undefined;
}

function readSpacing(text: string): Triple | undefined {
  const [x = 0, y = 0, z = 0, ...more] = readNumbers(text) ?? [];
  return Math.min(x, y, z) > 0 && more.length === 0 ? [x, y, z] : undefined;
}

function readRange(text: string): [number, number] | undefined {
  const [low = 0, high = 0, ...more] = readNumbers(text) ?? [];
  return low < high && more.length === 0 ? [low, high] : undefined;
}

function readSteps(text: string): number | undefined {
  const steps = readNumber(text);
  return Number.isInteger(steps) && Number(steps) >= 2 && Number(steps) <= 256 ? steps : undefined;
}

function readAboveZero(text: string): number | undefined {
  const number = readNumber(text);
  return Number(number) > 0 ? number : undefined;
}

function readShow(text: string): ReadonlySet<OverlayPart> | undefined {
  if (text === "none") return new Set();
  const parts = text.split(",").map((name) => oneOf(name, overlayParts));
  return parts.every((part) => part !== undefined) ? new Set(parts) : undefined;
}

export function readUrl(search: string): UrlState {
  const query = new URLSearchParams(search);
  const state: UrlState = {};
  const notes: string[] = [];
  /** The parameter's value, if it exists and is valid; adds a note if it is invalid. */
  const read = <T>(name: string, parse: (text: string) => T | undefined, expected: string) => {
    const text = query.get(name);
    if (text === null || text === "") return undefined;
    const value = parse(text);
    if (value === undefined) notes.push(ignored(name, text, expected));
    return value;
  };
  const volume = query.get("volume");
  if (volume) state.volume = volume;
  const scene = query.get("scene");
  if (scene) state.scene = scene;
  const src = query.get("src");
  if (src) state.src = src;
  const file = query.get("file");
  if (file) state.file = file;

  const spacing = read("spacing", readSpacing, pageTexts.isSpacing);
  if (spacing) state.spacing = spacing;
  const isovalues = read("isovalue", readNumbers, pageTexts.isNumbers);
  if (isovalues) state.isovalues = isovalues.slice(0, maxSurfaces);
  const colours = read("colour", readColours, pageTexts.isColours);
  if (colours) state.colours = colours;
  const opacities = read("opacity", readOpacities, pageTexts.isShares);
  if (opacities) state.opacities = opacities.map((o) => Math.max(o, minOpacity));
  if (opacities?.some((o) => o < minOpacity)) {
    notes.push(pageTexts.invisible(String(100 * minOpacity)));
  }

  const camera = read("camera", readCamera, "azimuth,elevation,distance,x,y,z");
  if (camera) state.camera = camera;
  const expectedProjection = pageTexts.isEither(...projections);
  const projection = read("projection", readProjection, expectedProjection);
  if (projection) state.projection = projection;
  const kinds = ["automatic", ...splatKinds] as const;
  const kind = read("kind", (text) => oneOf(text, kinds), kinds.join(", "));
  if (kind) state.kind = kind;
  const shading = read("shading", (text) => oneOf(text, shadings), shadings.join(", "));
  if (shading) state.shading = shading;
  const colourBy = read("colour-by", (text) => oneOf(text, colourings), colourings.join(", "));
  if (colourBy) state.colourBy = colourBy;
  const fieldName = read("field", (text) => text || undefined, pageTexts.isFieldName);
  const fieldRange = read("field-range", readRange, "low,high");
  const fieldScale = read(
    "field-scale",
    (text) => oneOf(text, fieldScales),
    fieldScales.join(", "),
  );
  const fieldSteps = read("field-steps", readSteps, "2 … 256");
  const fieldLines = read("field-lines", readAboveZero, pageTexts.isAboveZero);
  if (state.colourBy === "field" && !fieldName) {
    delete state.colourBy;
    notes.push(ignored("colour-by", "field", pageTexts.isFieldName));
  }
  if (fieldName) {
    const [range, scale, steps] = [fieldRange ?? null, fieldScale ?? "linear", fieldSteps ?? 0];
    state.field = { name: fieldName, range, scale, steps, lines: fieldLines ?? 0 };
  }
  const colourMap = read("map", (text) => oneOf(text, colourMaps), colourMaps.join(", "));
  if (colourMap) state.colourMap = colourMap;
  const background = read("background", readColour, pageTexts.isColour);
  if (background) state.background = background;
  const shade = read("shade", readShare, pageTexts.isShare);
  if (shade !== undefined) state.eyeDome = shade;
  for (const name of Object.keys(lightParameters)) {
    const light = read(name, (text) => readLight(name, text), expectedOfLight(name));
    if (light) state.light = { ...(state.light ?? defaultLight), ...light };
  }
  const time = read("time", readNumber, pageTexts.isNumber);
  if (time !== undefined) state.time = time;
  const show = read("show", readShow, pageTexts.isParts(overlayParts.join(",")));
  if (show) state.show = show;
  const measures = query.getAll("measure");
  if (measures.length > 0) state.measures = measures.filter((measure) => measure !== "none");
  read("clip", readBox, pageTexts.isBox);
  const switches = ["on", "off"] as const;
  read("clip-caps", (text) => oneOf(text, switches), pageTexts.isEither(...switches));
  for (const text of query.getAll("plane")) {
    if (!readPlane(text)) notes.push(ignored("plane", text, "x,y,z,offset"));
  }
  const clip = readClip(query);
  if (clip) state.clip = clip;
  const readAlong = (text: string) => (text === "none" ? noSlices.along : readSlices(text));
  const along = read("slices", readAlong, "x,y,z (0 … 1)");
  const plane = read("slice-plane", readPlane, "x,y,z,offset");
  const range = read("slice-range", readRange, "low,high");
  const sliceColours = ["map", "grey"] as const;
  const sliceColour = read(
    "slice-colours",
    (text) => oneOf(text, sliceColours),
    sliceColours.join(", "),
  );
  if (along || plane || range || sliceColour) {
    state.slices = {
      along: along ?? noSlices.along,
      ...(plane && { plane }),
      ...(range && { range }),
      ...(sliceColour === "map" && { mapped: true }),
    };
  }
  const layers = query.getAll("layer").map((text) => {
    const layer = readLayer(text);
    if (!layer) notes.push(ignored("layer", text, "volume:name;isovalue:1,2;…"));
    return layer;
  });
  const known = layers.filter((layer) => layer !== undefined);
  if (known.length > 0) state.layers = known;
  const order = read("layer-order", readOrder, pageTexts.isNumbers);
  // Without one of the layers, the numbers of the others differ.
  if (order && known.length === layers.length) state.layerOrder = order;
  if (notes.length > 0) state.notes = notes;
  return state;
}

/** The layers of the session that is kept for the page whose address has this query. */
export function keptLayers(search: string): Pick<UrlState, "layers" | "layerOrder"> {
  try {
    const text = sessionStorage.getItem(keptSessionKey) ?? "";
    const end = text.indexOf("\n");
    if (text.slice(0, end) !== search) return {};
    const { view } = JSON.parse(text.slice(end + 1)) as { view?: unknown };
    return typeof view === "string" ? readUrl(view) : {};
  } catch {
    return {}; // nothing was kept
  }
}

function ignored(name: string, text: string, expected: string): string {
  const shown = text.length > 40 ? `${text.slice(0, 40)}…` : text;
  return pageTexts.ignored(`${name}=${shown}`, expected);
}

/**
 * The query, with its question mark. Commas and the separators of the fields of layers are not escaped. All other
 * special characters are. Numbers have as many digits as are needed to read the same numbers, so the address gives
 * the same picture, pixel by pixel, on the page and with `isosplat render`.
 */
export function writeUrl(state: UrlState): string {
  const parts: string[] = [];
  const add = (name: string, value: string | undefined, plain = /%2C/g) => {
    if (value === undefined) return;
    parts.push(`${name}=${encodeURIComponent(value).replace(plain, decodeURIComponent)}`);
  };
  add("volume", state.volume);
  add("scene", state.scene);
  add("src", state.src);
  add("file", state.file);
  add("spacing", state.spacing?.join(","));
  add("isovalue", state.isovalues?.join(","));
  add("colour", state.colours?.map((c) => c.slice(1)).join(","));
  add("opacity", state.opacities?.join(","));
  if (state.camera) add("camera", writeCamera(state.camera));
  add("projection", state.projection);
  add("kind", state.kind);
  add("shading", state.shading);
  add("colour-by", state.colourBy);
  if (state.field) {
    const { name, range, scale, steps, lines } = state.field;
    add("field", name);
    add("field-range", range?.join(","));
    if (scale !== "linear") add("field-scale", scale);
    if (steps > 0) add("field-steps", String(steps));
    if (lines > 0 && Number.isFinite(lines)) add("field-lines", String(lines));
  }
  add("map", state.colourMap);
  add("background", state.background?.slice(1));
  add("shade", state.eyeDome?.toString());
  for (const name of Object.keys(lightParameters)) {
    if (state.light) add(name, writeLight(name, state.light));
  }
  if (state.clip) {
    const { low, high, planes, caps } = state.clip;
    const n = [low[0], high[0], low[1], high[1], low[2], high[2]];
    const isStated = isDefaultClip(state.clip) || !isWhole({ low, high, planes: [] });
    if (isStated) add("clip", n.join(","));
    for (const { normal, offset } of planes) add("plane", [...normal, offset].join(","));
    if (caps) add("clip-caps", "on");
  }
  if (state.slices) {
    const { along, plane, range, mapped } = state.slices;
    add("slices", isDefaultSlices(state.slices) ? "none" : writeSlices(along));
    if (plane) add("slice-plane", [...plane.normal, plane.offset].join(","));
    add("slice-range", range?.join(","));
    if (mapped) add("slice-colours", "map");
  }
  add("time", state.time?.toString());
  if (state.show) add("show", overlayParts.filter((p) => state.show?.has(p)).join(",") || "none");
  for (const layer of state.layers ?? []) add("layer", writeLayer(layer), /%(2C|3A|3B|2F)/g);
  add("layer-order", state.layerOrder?.join(","));
  for (const line of state.measures ?? []) add("measure", line);
  if (state.measures?.length === 0) add("measure", "none");
  return parts.length === 0 ? "" : `?${parts.join("&")}`;
}
