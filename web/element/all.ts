/** What `import … from "isosplat"` gives: the element, and what most programs need beside it. */
export {
  AssetError,
  type Chunk,
  type Core,
  CoreError,
  loadCore,
  maxHeaderBytes,
  type Points,
  type Store,
} from "../core/index.ts";
export { forecastSurface, SurfaceReader, saveSurface } from "../mesh/index.ts";
export {
  BlobSource,
  FileSource,
  faults,
  ServerSource,
  SiteSource,
  StreamError,
  StreamSession,
} from "../stream/index.ts";
export { RendererError, Viewer } from "../viewer/index.ts";
export * from "./index.ts";
