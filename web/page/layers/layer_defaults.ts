import type { Layer } from "../../viewer/layer.ts";
import { surfaceColours } from "../../viewer/surfaces.ts";
import type { Surface } from "../../viewer/types.ts";
import type { LayerPlace, LayerState } from "../address/layer_address.ts";

/** The title of a layer whose store has not been read. */
export function titleOfState({ name, place }: Pick<LayerState, "name" | "place">): string {
  return name || titleOfPlace(place);
}

export function titleOfPlace({ volume, src = "" }: LayerPlace): string {
  return volume ?? src.slice(src.lastIndexOf("/") + 1);
}

/** The surfaces of a layer, with the first colour that no other layer uses. */
export function inFreeColour(layer: Layer, layers: readonly Layer[]): readonly Surface[] {
  const others = layers.filter((each) => each !== layer);
  const used = new Set(others.flatMap(({ surfaces }) => surfaces.map(({ colour }) => colour)));
  const colour = surfaceColours.find((each) => !used.has(each));
  return colour ? layer.surfaces.map((surface) => ({ ...surface, colour })) : layer.surfaces;
}
