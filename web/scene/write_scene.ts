import type { Measurement } from "../measure/measurement.ts";
import { isDefaultClip } from "../viewer/clipping.ts";
import type { Layer } from "../viewer/layer.ts";
import { hasSlices, isDefaultSlices } from "../viewer/slices.ts";
import { isIdentity } from "../viewer/transform.ts";
import type { Camera, Clip, Slices, Surface } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import { lookDocument } from "./look_document.ts";
import type { ShownScene } from "./open_scene.ts";
import { type JsonObject, maxTextBytes, objectOf } from "./scene_document.ts";

export interface WriteSceneOptions {
  name: string;
  /** The scene that was opened. Its unknown members and its missing layers are kept. */
  scene: ShownScene | null;
  /** The name to write for a layer whose `name` is empty, such as the title of its volume. */
  nameOf: (layer: Layer) => string;
  measurements: readonly Measurement[];
  /** Whether to write the background. False if the page chooses it, as by its theme. */
  hasBackground: boolean;
}

export interface WrittenScene {
  /** JSON. Null if no layer has an address. */
  text: string | null;
  /** The layers that are not in the scene, because their stores are files of this device, without an address. */
  left: readonly Layer[];
}

/**
 * Writes the present picture of a viewer as a scene document (shared/core/scene/SCENE.md): its layers with the
 * absolute addresses of their stores, time, camera, clipping, slices, look and measurements. Opening the document
 * shows the same picture.
 */
export function writeScene(viewer: Viewer, options: WriteSceneOptions): WrittenScene {
  const { name, scene, measurements, hasBackground } = options;
  const left: Layer[] = [];
  const layers: JsonObject[] = [];
  for (const layer of inOrder(viewer)) {
    const written = writeLayer(layer, options);
    if (written) layers.push(written);
    else left.push(layer);
  }
  if (layers.length === 0) return { text: null, left };
  const before = scene?.document.json ?? {};
  const lost = scene?.missing.flatMap(({ index }) => lostLayer(scene, index) ?? []) ?? [];
  const { time, camera, clip, slices, look } = viewer;
  const document = {
    ...before,
    format: "isosplat-scene",
    version: 1,
    ...(name && { name: shortened(name) }),
    layers: [...layers, ...lost],
    ...(time && {
      time: {
        ...objectOf(before.time),
        steps: time.values,
        ...(time.unit && { unit: time.unit }),
        step: time.wantedStep,
      },
    }),
    camera: camera ? { ...objectOf(before.camera), ...cameraDocument(camera) } : undefined,
    clip: isDefaultClip(clip) ? undefined : { ...objectOf(before.clip), ...clipDocument(clip) },
    slices: isDefaultSlices(slices)
      ? undefined
      : { ...objectOf(before.slices), ...slicesDocument(slices) },
    look: lookDocument(look, before.look),
    measurements:
      measurements.length > 0 ? measurementsDocument(measurements, before.measurements) : undefined,
    background: hasBackground ? look.background : undefined,
  };
  return { text: `${JSON.stringify(document, null, 2)}\n`, left };
}

/**
 * The layers in the order of the document. The clip box, slices and colours by value refer to the first layer of
 * the document. If any of them is set, the viewer's first layer comes first, wherever the list shows it.
 */
function inOrder({ layers, clip, slices, look }: Viewer): readonly Layer[] {
  const isWhole = clip.low.every((low) => low === 0) && clip.high.every((high) => high === 1);
  if (isWhole && !hasSlices(slices) && look.colourBy === "isosurface") return layers;
  const [some] = layers;
  const first = layers.reduce((a, b) => (a && b.id < a.id ? b : a), some);
  return first ? [first, ...layers.filter((layer) => layer !== first)] : layers;
}

/** The member of `layers` for a layer. Undefined if one of its stores has no address, or one that is too long. */
function writeLayer(layer: Layer, { scene, nameOf }: WriteSceneOptions): JsonObject | undefined {
  const index = scene?.layers.findIndex((each) => each?.sources === layer.sources) ?? -1;
  const addresses = scene && index >= 0 ? addressesOf(scene, index) : [layer.source.address];
  const stores = addresses.filter((address) => address !== undefined && isShort(address));
  if (stores.length < addresses.length) return undefined;
  const before = index >= 0 && scene ? layerOf(scene, index) : {};
  const { store: _, stores: __, ...others } = before;
  const name = layer.name || nameOf(layer);
  const { group, surfaces, visible, transform, label } = layer;
  return {
    ...others,
    ...(name ? { name: shortened(name) } : {}),
    ...(group || others.group ? { group: shortened(group) } : {}),
    ...(layer.hasSteps ? { stores } : { store: stores[0] }),
    ...(surfaces.length > 0 && { surfaces: surfacesDocument(surfaces, before.surfaces) }),
    visible: visible ? undefined : false,
    transform: isIdentity(transform) ? undefined : transform,
    ...(label && { label: { ...objectOf(others.label), ...label } }),
  };
}

/** The member of `layers` for a layer that could not be opened, with absolute addresses. */
function lostLayer(scene: ShownScene, index: number): JsonObject | undefined {
  const { store: _, stores: __, ...others } = layerOf(scene, index);
  const addresses = addressesOf(scene, index);
  if (addresses.some((address) => address === undefined)) return undefined;
  return { ...others, ...(addresses.length > 1 ? { stores: addresses } : { store: addresses[0] }) };
}

function layerOf({ document }: ShownScene, index: number): JsonObject {
  const { layers } = document.json;
  return Array.isArray(layers) ? objectOf(layers[index]) : {};
}

/** The absolute addresses of the stores of a layer of the scene. */
function addressesOf({ document, source }: ShownScene, index: number): (string | undefined)[] {
  const { stores = [] } = document.layers[index] ?? {};
  return stores.map((path) => {
    try {
      return source(path).address;
    } catch {
      return undefined; // the layer is missing because this address is wrong
    }
  });
}

function surfacesDocument(surfaces: readonly Surface[], before: unknown): JsonObject[] {
  return surfaces.map(({ isovalue, colour, opacity }, i) => {
    const { opacity: _, ...others } = Array.isArray(before) ? objectOf(before[i]) : {};
    return { ...others, isovalue, colour, ...(opacity !== 1 && { opacity }) };
  });
}

function cameraDocument({ projection, fieldOfView, ...camera }: Camera): JsonObject {
  const { target, distance, azimuth, elevation, roll } = camera;
  return {
    ...{ target, distance, azimuth, elevation, roll },
    field_of_view: fieldOfView,
    orthographic: projection === "orthographic",
  };
}

function clipDocument({ low, high, planes, caps = false }: Clip): JsonObject {
  return { box: { low, high }, planes, caps };
}

function slicesDocument({ along, plane, range, mapped }: Slices): JsonObject {
  return { along, plane, range, mapped };
}

/** Keeps the unknown members of a measurement of the scene if its points have not changed. */
function measurementsDocument(
  measurements: readonly Measurement[],
  before: unknown,
): readonly JsonObject[] {
  const known = new Map<string, JsonObject>();
  for (const each of Array.isArray(before) ? before : []) {
    known.set(placesOf(objectOf(each).points), objectOf(each));
  }
  return measurements.map(({ kind, points, text }) => {
    const same = known.get(placesOf(points)) ?? {};
    const samePoints = Array.isArray(same.points) ? same.points : [];
    const kept = points.map((point, i) => ({ ...objectOf(samePoints[i]), ...point }));
    return { ...same, kind, points: kept, text };
  });
}

function placesOf(points: unknown): string {
  const places = Array.isArray(points) ? points.map((point) => objectOf(point).position) : [];
  return JSON.stringify(places);
}

const utf8 = new TextEncoder();

function isShort(text: string): boolean {
  return utf8.encode(text).length <= maxTextBytes;
}

/** The text, cut at the maximum length of texts in scenes. */
function shortened(text: string): string {
  if (isShort(text)) return text;
  // With `stream`, the decoder leaves out a character that was cut in two.
  return new TextDecoder().decode(utf8.encode(text).subarray(0, maxTextBytes), { stream: true });
}
