/** Defines <isosplat-viewer> and <isosplat-layer>, and their types in the templates of Vue 3. */
import type { HTMLAttributes, ReservedProps } from "vue";
import type { IsosplatLayerEvents, IsosplatViewerEvents } from "./element_events.ts";
import type { IsosplatLayerProps, IsosplatViewerProps } from "./element_props.ts";
import type { IsosplatLayerElement } from "./isosplat_layer.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

export * from "./index.ts";

/** `@isovaluechange` is the property `onIsovaluechange`. */
type Listeners<Events> = {
  [Name in keyof Events & string as `on${Capitalize<Name>}`]?:
    | ((event: Events[Name]) => void)
    | undefined;
};

type Props<Own, Events> = ReservedProps &
  Omit<HTMLAttributes, keyof Own | keyof Listeners<Events>> &
  Own &
  Listeners<Events>;

declare module "vue" {
  interface GlobalComponents {
    "isosplat-viewer": new () => IsosplatViewerElement & {
      $props: Props<IsosplatViewerProps, IsosplatViewerEvents>;
    };
    "isosplat-layer": new () => IsosplatLayerElement & {
      $props: Props<IsosplatLayerProps, IsosplatLayerEvents>;
    };
  }
}
