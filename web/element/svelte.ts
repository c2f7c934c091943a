/** Defines <isosplat-viewer>, and its types in the markup of Svelte 5. */
import type * as Svelte from "svelte/elements";
import type { IsosplatViewerListeners, IsosplatViewerProps } from "./element_props.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

export * from "./index.ts";

declare module "svelte/elements" {
  interface SvelteHTMLElements {
    "isosplat-viewer": Omit<
      Svelte.HTMLAttributes<IsosplatViewerElement>,
      keyof IsosplatViewerProps | keyof IsosplatViewerListeners
    > &
      IsosplatViewerProps &
      IsosplatViewerListeners;
  }
}
