import { FileSource, type IsosplatViewerElement, loadCore, setAssetBase, Viewer } from "isosplat";
import { type Core, maxHeaderBytes } from "isosplat/core";
import "isosplat/element";
import { saveSurface } from "isosplat/mesh";
import { type Progress, ServerSource } from "isosplat/stream";
import { type Camera, RendererError } from "isosplat/viewer";

export async function run(canvas: HTMLCanvasElement, bytes: Uint8Array): Promise<number> {
  setAssetBase("/isosplat/");
  const core: Core = await loadCore();
  const store = core.openStore(bytes.subarray(0, maxHeaderBytes));
  const viewer = new Viewer(canvas, { controls: false });
  viewer.on("progress", (progress: Progress) => console.log(progress.state));
  viewer.on("error", (error) => console.log(error instanceof RendererError, error.kind));
  await viewer.open(new FileSource("head.isosplat"));
  const camera: Camera | null = viewer.camera;
  const saved = await saveSurface(new ServerSource({ volume: "head" }), 60.5);
  const view: IsosplatViewerElement = document.createElement("isosplat-viewer");
  view.addEventListener("isovaluechange", ({ detail }) => console.log(detail.length));
  return store.info.levels + saved.triangles + (camera?.azimuth ?? 0);
}
