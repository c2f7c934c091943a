/** Defines <isosplat-viewer>, and its types in the JSX of React 19. */
import type * as React from "react";
import type { IsosplatViewerListeners, IsosplatViewerProps } from "./element_props.ts";
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

export * from "./index.ts";

declare module "react" {
  namespace JSX {
    interface IntrinsicElements {
      "isosplat-viewer": React.DetailedHTMLProps<
        React.HTMLAttributes<IsosplatViewerElement>,
        IsosplatViewerElement
      > &
        IsosplatViewerProps &
        IsosplatViewerListeners;
    }
  }
}
