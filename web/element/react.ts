/** Defines <isosplat-viewer> and <isosplat-layer>, and their types in the JSX of React 19. */
import type * as React from "react";
import type {
  IsosplatLayerListeners,
  IsosplatLayerProps,
  IsosplatViewerListeners,
  IsosplatViewerProps,
} from "./element_props.ts";
import type { IsosplatLayerElement } from "./isosplat_layer.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

export * from "./index.ts";

type Html<E> = React.DetailedHTMLProps<React.HTMLAttributes<E>, E>;

declare module "react" {
  namespace JSX {
    interface IntrinsicElements {
      "isosplat-viewer": Html<IsosplatViewerElement> &
        IsosplatViewerProps &
        IsosplatViewerListeners;
      "isosplat-layer": Html<IsosplatLayerElement> & IsosplatLayerProps & IsosplatLayerListeners;
    }
  }
}
