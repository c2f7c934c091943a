import type { SceneSource } from "../scene/scene_source.ts";
import type { Source } from "../stream/source.ts";
import type { PlayMode } from "../viewer/time_order.ts";
import type { Transform } from "../viewer/transform.ts";
import type { Camera, Clip, LookChange, Projection, Slices, Surface } from "../viewer/types.ts";
import type { IsosplatLayerEvents, IsosplatViewerEvents } from "./element_events.ts";

/**
 * The properties of `<isosplat-viewer>` that frameworks set: attributes, and properties of the element with
 * the same name.
 */
export interface IsosplatViewerProps {
  src?: string | undefined;
  source?: Source | null | undefined;
  scene?: string | undefined;
  sceneSource?: SceneSource | null | undefined;
  /** The step that is shown, of a scene that changes with time. */
  step?: number | undefined;
  /** Steps per second while a scene plays. */
  rate?: number | undefined;
  /** The behaviour after the last step. */
  loop?: PlayMode | undefined;
  /** The attribute, for the first isovalues; `isovalues` are the present ones. */
  isovalue?: string | number | undefined;
  isovalues?: readonly number[] | undefined;
  surfaces?: readonly Surface[] | undefined;
  colour?: string | undefined;
  opacity?: string | number | undefined;
  camera?: Camera | null | undefined;
  projection?: Projection | undefined;
  clip?: Clip | undefined;
  slices?: Slices | undefined;
  look?: LookChange | undefined;
  background?: string | undefined;
  controls?: boolean | undefined;
  show?: string | undefined;
  link?: string | undefined;
}

/** The properties of `<isosplat-layer>` that frameworks set. */
export interface IsosplatLayerProps {
  src?: string | undefined;
  source?: Source | null | undefined;
  name?: string | undefined;
  group?: string | undefined;
  /** The attribute, for the first isovalues; `isovalues` are the present ones. */
  isovalue?: string | number | undefined;
  isovalues?: readonly number[] | undefined;
  surfaces?: readonly Surface[] | undefined;
  colour?: string | undefined;
  opacity?: string | number | undefined;
  visible?: boolean | undefined;
  transform?: Transform | undefined;
}

/** Listeners as React and Svelte name them: `onisovaluechange`. */
export type Listeners<Events extends Record<keyof Events, Event>> = {
  [Name in keyof Events & string as `on${Name}`]?: ((event: Events[Name]) => void) | undefined;
};

export type IsosplatViewerListeners = Listeners<IsosplatViewerEvents>;
export type IsosplatLayerListeners = Listeners<IsosplatLayerEvents>;
