/** Defines <isosplat-viewer> and <isosplat-layer>, and their types in the markup of Svelte 5. */
import type * as Svelte from "svelte/elements";
import type {
  IsosplatLayerListeners,
  IsosplatLayerProps,
  IsosplatViewerListeners,
  IsosplatViewerProps,
} from "./element_props.ts";
import type { IsosplatLayerElement } from "./isosplat_layer.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

export * from "./index.ts";

type Html<E extends EventTarget, Own> = Omit<Svelte.HTMLAttributes<E>, keyof Own> & Own;

declare module "svelte/elements" {
  interface SvelteHTMLElements {
    "isosplat-viewer": Html<IsosplatViewerElement, IsosplatViewerProps & IsosplatViewerListeners>;
    "isosplat-layer": Html<IsosplatLayerElement, IsosplatLayerProps & IsosplatLayerListeners>;
  }
}
