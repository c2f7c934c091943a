import { sameValue } from "../viewer/same_value.ts";
import type { IsosplatLayerElement } from "./isosplat_layer.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";
import type { LayerTrait } from "./notebook_traits.ts";

/** The last value of the trait that was applied to a child element. */
const shown = new WeakMap<IsosplatLayerElement, LayerTrait>();

/** Shows the layers of the trait as child elements. Elements with the same `src` are kept, with their loaded data. */
export function showLayers(element: IsosplatViewerElement, layers: readonly LayerTrait[]): void {
  const present = [...element.querySelectorAll("isosplat-layer")];
  const left = new Set(present);
  const wanted = layers.map((layer) => {
    const same = [...left].find(({ src }) => src === layer.src);
    const child = same ?? document.createElement("isosplat-layer");
    left.delete(child);
    if (!sameValue(shown.get(child), layer)) show(child, layer);
    return child;
  });
  for (const child of left) child.remove();
  if (wanted.some((child, i) => child !== element.querySelectorAll("isosplat-layer")[i])) {
    element.append(...wanted);
  }
}

function show(child: IsosplatLayerElement, layer: LayerTrait): void {
  const before = shown.get(child);
  shown.set(child, layer);
  const { src, name, group, visible, surfaces, transform } = layer;
  if (src !== child.src) child.src = src;
  child.name = name;
  child.group = group;
  child.visible = visible;
  // Isovalues that a visitor has chosen stay, unless the program states others.
  if (!sameValue(before?.surfaces ?? [], surfaces ?? [])) child.surfaces = surfaces;
  if (!sameValue(before?.transform ?? [], transform ?? [])) child.transform = transform;
}
