import type { Source } from "../stream/source.ts";
import type { Layer, LayerOptions } from "../viewer/layer.ts";
import { firstSurface, surfaceColour } from "../viewer/surfaces.ts";
import type { Camera, Label, Surface } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import type {
  CameraDocument,
  LayerDocument,
  SceneDocument,
  SurfaceDocument,
} from "./scene_document.ts";
import type { OpenedScene, SceneSource } from "./scene_source.ts";

export interface OpenSceneOptions {
  /**
   * The index of the step that is shown first, or a function that chooses it from the values of the steps. If it
   * is undefined, or the function returns undefined, the step of the scene is used.
   */
  step?: number | ((values: readonly number[]) => number | undefined);
  signal?: AbortSignal;
}

/** A layer of a scene that could not be opened. */
export interface MissingLayer {
  /** Its index in the document. */
  index: number;
  name: string;
  error: unknown;
}

/** The scene that a viewer shows. */
export interface ShownScene {
  readonly document: SceneDocument;
  /** The viewer's layer for each layer of the document; null if it is missing. */
  readonly layers: readonly (Layer | null)[];
  readonly missing: readonly MissingLayer[];
  /** A store of the document, by its path or address there. Throws a StreamError for wrong addresses. */
  readonly source: OpenedScene["source"];
}

/**
 * Shows a scene instead of all present layers, with its camera, clipping and slices, and those settings of the
 * look that it states. Resolves when the headers of all visible layers have been read; the surfaces follow. A
 * store that cannot be read does not affect the other layers. Rejects with a StreamError if the scene or all of
 * its layers cannot be read, with a RendererError, or with the signal's reason.
 */
export async function openScene(
  viewer: Viewer,
  source: SceneSource,
  { step, signal = new AbortController().signal }: OpenSceneOptions = {},
): Promise<ShownScene> {
  const opened = await source.open(await viewer.core(), signal);
  signal.throwIfAborted();
  const { document } = opened;
  const { time, background } = document;
  const values = time?.values ?? [0];
  const wanted = (typeof step === "function" ? step(values) : step) ?? document.step;
  const first = Math.min(Math.max(0, Math.trunc(wanted)), values.length - 1);
  viewer.setTime(time, first);
  viewer.setClip(document.clip);
  viewer.setSlices(document.slices);
  viewer.setLook({
    ...document.look,
    ...(background && { background: background.slice(0, 7) }),
  });
  const shownPaths = document.layers
    .filter((layer) => layer.visible)
    .flatMap((layer) => layer.stores[Math.min(first, layer.stores.length - 1)] ?? []);
  void opened.fetchFirst(shownPaths).catch(() => {}); // the layers report it
  const layers: (Layer | null)[] = [];
  const missing: MissingLayer[] = [];
  await Promise.all(
    document.layers.map(async (layer, index) => {
      layers.push(null);
      try {
        layers[index] = await addLayer(viewer, opened, document, index, signal);
      } catch (error) {
        signal.throwIfAborted();
        missing.push({ index, name: layer.name, error });
      }
    }),
  );
  if (missing.length === document.layers.length) throw missing[0]?.error;
  if (document.camera) viewer.setCamera(cameraOf(document.camera));
  else viewer.reset();
  missing.sort((a, b) => a.index - b.index);
  return { document, layers, missing, source: (path) => opened.source(path) };
}

async function addLayer(
  viewer: Viewer,
  opened: OpenedScene,
  document: SceneDocument,
  index: number,
  signal: AbortSignal,
): Promise<Layer> {
  const layer = document.layers[index] as LayerDocument;
  const [only] = layer.stores;
  const hasSteps = document.time !== null && layer.stores.length > 1;
  const fetched = new Set<number>();
  const sourceOf = (step: number): Source => {
    const group = Math.floor(step / stepsTogether);
    if (hasSteps && step !== viewer.time?.step && !fetched.has(group)) {
      fetched.add(group);
      const paths = layer.stores.slice(group * stepsTogether, (group + 1) * stepsTogether);
      void opened.fetchFirst(paths).catch(() => {}); // the layer reports it
    }
    return opened.source(layer.stores[step] ?? only ?? "");
  };
  const options = layerOptionsOf(document, index);
  const added = await viewer.addLayer(hasSteps ? sourceOf : sourceOf(0), { ...options, signal });
  const { info } = added;
  if (!options.surfaces && info) {
    const colour = surfaceColour(colourNumber(document, index));
    added.surfaces = [{ ...firstSurface(info), colour }];
  }
  return added;
}

type DocumentLayerOptions = Required<Pick<LayerOptions, "name" | "group" | "partOf" | "visible">> &
  Pick<LayerOptions, "surfaces" | "transform"> & { label: Label | null };

/** The options with which Viewer.addLayer adds a layer of the document. */
export function layerOptionsOf(document: SceneDocument, index: number): DocumentLayerOptions {
  const layer = document.layers[index] as LayerDocument;
  const { name, group, partOf, visible, label, transform } = layer;
  const number = colourNumber(document, index);
  const surfaces = layer.surfaces.map((surface, i) => surfaceOf(surface, number + i));
  return {
    ...{ name, group, partOf, visible, label },
    ...(transform && { transform }),
    ...(surfaces.length > 0 && { surfaces }),
  };
}

/** The number of steps whose first parts are fetched together, because each part is small. */
const stepsTogether = 8;

/** The number of visible layers before this one, so that layers without a colour get different colours. */
function colourNumber({ layers }: SceneDocument, index: number): number {
  return layers.slice(0, index).filter((layer) => layer.visible).length;
}

function surfaceOf({ isovalue, colour, opacity }: SurfaceDocument, number: number): Surface {
  return { isovalue, colour: colour ?? surfaceColour(number), opacity };
}

function cameraOf({ isOrthographic, ...camera }: CameraDocument): Camera {
  return { ...camera, projection: isOrthographic ? "orthographic" : "perspective" };
}
