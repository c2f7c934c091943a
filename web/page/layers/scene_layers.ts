import { layerOptionsOf } from "../../scene/open_scene.ts";
import type { SceneSource } from "../../scene/scene_source.ts";
import type { Source } from "../../stream/source.ts";
import { layersTexts } from "../../texts/layers.ts";
import { identity } from "../../viewer/transform.ts";
import type { Label } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { LayerContent, LayerPlace } from "../address/layer_address.ts";

/** A layer of a scene, to be added to a picture. */
export interface SceneLayer {
  source: Source;
  place: LayerPlace;
  content: LayerContent & { label: Label | null };
}

/**
 * Reads the layers of a scene, to add them to the picture of a viewer. Resolves to a reason, for the visitor, if
 * this is not possible: layers that change with time have the steps of their scene. Rejects with a StreamError.
 */
export async function layersOfScene(
  viewer: Viewer,
  scene: SceneSource,
): Promise<SceneLayer[] | string> {
  const { signal } = new AbortController();
  const opened = await scene.open(await viewer.core(), signal);
  const { document } = opened;
  if (document.layers.some(({ stores }) => stores.length > 1)) {
    return layersTexts.changesWithTime(document.name || scene.name);
  }
  const paths = document.layers.flatMap(({ visible, stores }) => (visible ? stores : []));
  void opened.fetchFirst(paths).catch(() => {}); // the layers report it
  return document.layers.map((layer, index): SceneLayer => {
    const source = opened.source(layer.stores[0] ?? "");
    const { surfaces = [], transform = identity, ...options } = layerOptionsOf(document, index);
    const place = source.address === undefined ? {} : { src: source.address };
    return { source, place, content: { ...options, surfaces, transform } };
  });
}
