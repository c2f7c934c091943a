/** Defines <isosplat-viewer>, and its types in the templates of Vue 3. */
import type { HTMLAttributes, ReservedProps } from "vue";
import type { IsosplatViewerEvents } from "./element_events.ts";
import type { IsosplatViewerProps } from "./element_props.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

export * from "./index.ts";

/** `@isovaluechange` is the property `onIsovaluechange`. */
type Listeners = {
  [Name in keyof IsosplatViewerEvents as `on${Capitalize<Name>}`]?:
    | ((event: IsosplatViewerEvents[Name]) => void)
    | undefined;
};

declare module "vue" {
  interface GlobalComponents {
    "isosplat-viewer": new () => IsosplatViewerElement & {
      $props: ReservedProps &
        Omit<HTMLAttributes, keyof IsosplatViewerProps | keyof Listeners> &
        IsosplatViewerProps &
        Listeners;
    };
  }
}
