import type { Layer } from "../../viewer/layer.ts";
import { readColours, readNumbers, readOpacities } from "../../viewer/setting_text.ts";
import { surfacesAt } from "../../viewer/surfaces.ts";
import { checkedTransform, identity, type Transform } from "../../viewer/transform.ts";
import { type Label, maxSurfaces, type Surface } from "../../viewer/types.ts";

/** Where the store of a layer is: as `volume` and `src` of the page's address. */
export interface LayerPlace {
  volume?: string;
  src?: string;
}

/** The properties of a layer that the page can change. */
export interface LayerContent {
  name: string;
  group: string;
  visible: boolean;
  surfaces: readonly Surface[];
  transform: Transform;
}

/** A layer of the page, as the list shows it. */
export interface LayerState extends LayerContent {
  /** Identifies the layer within its page, also after it was removed and has returned. */
  key: number;
  /** Layer.sources. */
  source: Layer["sources"];
  /** Empty for layers that the address itself opens: its volume, or those of its scene. */
  place: LayerPlace;
  /** Layer.label. */
  label?: Label | null;
}

/** The layers of a page. */
export interface LayersView {
  /**
   * The layers that the address opens, in their initial state: the page's volume, or the layers of its scene.
   * Undefined: the scene's layer is missing.
   */
  opened: readonly (LayerState | undefined)[];
  /** The present layers, in the order of the list. */
  present: readonly LayerState[];
}

/**
 * A layer in the address: one that is added, which has a place, or a change of one that the address
 * opens itself, which has an index.
 */
export interface LayerAddress extends LayerPlace {
  index?: number;
  isRemoved?: boolean;
  name?: string;
  group?: string;
  visible?: boolean;
  isovalues?: number[];
  colours?: string[];
  opacities?: number[];
  transform?: Transform;
  /** Of a layer that is added. */
  label?: Label;
}

/** As in a scene: SCENE.md. */
const mostLayers = 4096;
const longestName = 1024;

/**
 * Reads the parameter `layer`: fields `name:value` with semicolons between them.
 *
 *   layer=volume:bone;name:Bone;group:CT;visible:off;isovalue:300,500;colour:d9ccb3,c8553d;opacity:1,0.4
 *   layer=src:https://…/dose.isosplat;transform:1,0,0,5,0,1,0,0,0,0,1,0     the first three rows
 *   layer=src:https://…/seg.isobundle#liver.isosplat;label:7,185293,1482345     value, voxels, volume of a label
 *   layer=index:2;visible:off      the third layer of the scene, or with index:0 the page's volume
 *   layer=index:3;removed:on
 *
 * Undefined if the text is not valid.
 */
export function readLayer(text: string): LayerAddress | undefined {
  const layer: LayerAddress = {};
  for (const field of text.split(";")) {
    const colon = field.indexOf(":");
    const value = unescaped(field.slice(colon + 1));
    if (colon < 1 || value === undefined) return undefined;
    if (!readField(layer, field.slice(0, colon), value)) return undefined;
  }
  const places = [layer.volume, layer.src, layer.index].filter((each) => each !== undefined);
  return places.length === 1 ? layer : undefined;
}

/** Returns whether the field is known and valid. */
function readField(layer: LayerAddress, name: string, text: string): boolean {
  const put = <Key extends keyof LayerAddress>(key: Key, value: LayerAddress[Key] | undefined) => {
    if (value === undefined) return false;
    layer[key] = value;
    return true;
  };
  switch (name) {
    case "volume":
    case "src":
      return put(name, text || undefined);
    case "name":
    case "group":
      return put(name, text.length <= longestName ? text : undefined);
    case "index":
      return put("index", /^\d{1,4}$/.test(text) && +text < mostLayers ? +text : undefined);
    case "removed":
      return put("isRemoved", text === "on" ? true : undefined);
    case "visible":
      return put("visible", text === "on" || text === "off" ? text === "on" : undefined);
    case "isovalue":
      return put("isovalues", readNumbers(text)?.slice(0, maxSurfaces));
    case "colour":
      return put("colours", readColours(text));
    case "opacity":
      return put("opacities", readOpacities(text));
    case "label":
      return put("label", readLabel(text));
    case "transform":
      return put("transform", readTransform(text));
    default:
      return false;
  }
}

/** The first three rows, or all four. */
function readTransform(text: string): Transform | undefined {
  const numbers = readNumbers(text) ?? [];
  try {
    return checkedTransform(numbers.length === 12 ? [...numbers, 0, 0, 0, 1] : numbers);
  } catch {
    return undefined;
  }
}

function readLabel(text: string): Label | undefined {
  const [value, voxels = -1, volume = -1, ...more] = readNumbers(text) ?? [];
  const isLabel = value !== undefined && voxels >= 0 && volume >= 0 && more.length === 0;
  return isLabel ? { value, voxels, volume } : undefined;
}

function unescaped(text: string): string | undefined {
  try {
    return decodeURIComponent(text);
  } catch {
    return undefined;
  }
}

/** The text that readLayer reads. */
export function writeLayer(layer: LayerAddress): string {
  const fields: string[] = [];
  const add = (name: string, value: string | undefined) => {
    if (value !== undefined) fields.push(`${name}:${value.replace(/[%;]/g, encodeURIComponent)}`);
  };
  add("volume", layer.volume);
  add("src", layer.src);
  add("index", layer.index?.toString());
  if (layer.isRemoved) add("removed", "on");
  add("name", layer.name);
  add("group", layer.group);
  if (layer.visible !== undefined) add("visible", layer.visible ? "on" : "off");
  add("isovalue", layer.isovalues?.join(","));
  add("colour", layer.colours?.map((colour) => colour.slice(1)).join(","));
  add("opacity", layer.opacities?.join(","));
  add("transform", layer.transform?.slice(0, 12).join(","));
  const { label } = layer;
  if (label) add("label", [label.value, label.voxels, label.volume].join(","));
  return fields.join(";");
}

/**
 * The order of the layers: a permutation of their numbers, which are the indices of those that the address
 * opens itself, and then those of the parameters `layer` with a place.
 */
export function readOrder(text: string): number[] | undefined {
  const order = readNumbers(text) ?? [];
  const isOrder =
    order.length > 0 &&
    order.every((number) => Number.isInteger(number) && number >= 0 && number < 2 * mostLayers) &&
    new Set(order).size === order.length;
  return isOrder ? order : undefined;
}

/** The content of a layer with these settings. Members that they lack keep their previous values. */
export function contentOf(before: LayerContent, layer: LayerAddress): LayerContent {
  const { isovalues, colours, opacities } = layer;
  return {
    name: layer.name ?? before.name,
    group: layer.group ?? before.group,
    visible: layer.visible ?? before.visible,
    surfaces: isovalues ? surfacesAt(isovalues, colours, opacities) : before.surfaces,
    transform: layer.transform ?? before.transform,
  };
}

/**
 * The layers that an address describes, as they are listed. `make`: a state for one with a place; undefined
 * if its place cannot be opened. `unknown`: the number of changes of layers that do not exist.
 */
export async function layersOfAddress(
  opened: LayersView["opened"],
  layers: readonly LayerAddress[],
  order: readonly number[] | undefined,
  make: (layer: LayerAddress) => Promise<LayerState | undefined>,
): Promise<{ present: LayerState[]; unknown: number }> {
  const numbered: (LayerState | undefined)[] = [...opened];
  let unknown = 0;
  for (const layer of layers) {
    const { index } = layer;
    const before = index === undefined ? undefined : opened[index];
    if (index === undefined) numbered.push(await make(layer));
    else if (!before) unknown += 1;
    else {
      numbered[index] = layer.isRemoved ? undefined : { ...before, ...contentOf(before, layer) };
    }
  }
  // Numbers that the order does not have come last.
  const rest = numbered.map((_, number) => number).filter((number) => !order?.includes(number));
  const sorted = [...(order ?? []), ...rest].map((number) => numbered[number]);
  return { present: sorted.filter((state) => state !== undefined), unknown };
}

/** A layer with default settings. Its store determines its surfaces. */
export const plainLayer: LayerContent = {
  name: "",
  group: "",
  visible: true,
  surfaces: [],
  transform: identity,
};

/** The parameters for these layers: only what differs from what the address opens itself. */
export function layersAddress({ opened, present }: LayersView): {
  layers: LayerAddress[];
  order: number[] | undefined;
} {
  const now = new Map(present.map((layer) => [layer.key, layer]));
  const first = opened.findIndex((layer) => layer !== undefined);
  const layers = opened.flatMap((before, index): LayerAddress[] => {
    if (!before) return [];
    const layer = now.get(before.key);
    if (!layer) return [{ index, isRemoved: true }];
    // The address has the surfaces of the first layer in its own parameters.
    const same = index === first ? { ...before, surfaces: layer.surfaces } : before;
    const changes = differences(same, layer);
    return Object.keys(changes).length > 0 ? [{ index, ...changes }] : [];
  });
  const numbers = new Map(
    opened.flatMap((layer, index) => (layer ? [[layer.key, index] as const] : [])),
  );
  let next = opened.length;
  for (const layer of present) {
    const hasPlace = layer.place.volume !== undefined || layer.place.src !== undefined;
    if (numbers.has(layer.key) || !hasPlace) continue;
    numbers.set(layer.key, next++);
    const { label } = layer;
    layers.push({
      ...layer.place,
      ...differences(plainLayer, layer),
      ...(label && { label }),
    });
  }
  const order = present.flatMap(({ key }) => numbers.get(key) ?? []);
  const isAscending = order.every((number, i) => i === 0 || number > (order[i - 1] ?? 0));
  return { layers, order: isAscending ? undefined : order };
}

function differences(before: LayerContent, now: LayerContent): LayerAddress {
  const changes: LayerAddress = {};
  if (now.name !== before.name) changes.name = now.name;
  if (now.group !== before.group) changes.group = now.group;
  if (now.visible !== before.visible) changes.visible = now.visible;
  if (!isSame(now.surfaces.flatMap(numbersOf), before.surfaces.flatMap(numbersOf))) {
    changes.isovalues = now.surfaces.map(({ isovalue }) => isovalue);
    changes.colours = now.surfaces.map(({ colour }) => colour);
    if (now.surfaces.some(({ opacity }) => opacity !== 1)) {
      changes.opacities = now.surfaces.map(({ opacity }) => opacity);
    }
  }
  if (!isSame(now.transform, before.transform)) changes.transform = now.transform;
  return changes;
}

function numbersOf({ isovalue, colour, opacity }: Surface): (number | string)[] {
  return [isovalue, colour, opacity];
}

function isSame<T>(a: readonly T[], b: readonly T[]): boolean {
  return a.length === b.length && a.every((each, i) => each === b[i]);
}
