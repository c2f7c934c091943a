import type { Source } from "../stream/source.ts";
import type { Camera, Clip, Look, Projection, Slices, Surface } from "../viewer/types.ts";
import type { IsosplatViewerEvents } from "./element_events.ts";

/**
 * The properties that frameworks set: attributes, and properties of the element with the same name.
 */
export interface IsosplatViewerProps {
  src?: string | undefined;
  source?: Source | null | undefined;
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
  look?: Partial<Look> | undefined;
  background?: string | undefined;
  controls?: boolean | undefined;
  show?: string | undefined;
  link?: string | undefined;
}

/** Listeners as React and Svelte name them: `onisovaluechange`. */
export type IsosplatViewerListeners = {
  [Name in keyof IsosplatViewerEvents as `on${Name}`]?:
    | ((event: IsosplatViewerEvents[Name]) => void)
    | undefined;
};
