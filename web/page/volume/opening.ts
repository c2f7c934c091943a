import type { StoreInfo } from "../../core/types.ts";
import type { ShownScene } from "../../scene/open_scene.ts";
import { pageTexts } from "../../texts/page.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { Camera, Look, Surface } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { SceneTarget, StoreTarget, Target } from "../address/target.ts";
import type { UrlState } from "../address/url_state.ts";
import { takeSpacing } from "./entered_spacing.ts";

/** The view with which a volume is opened. */
export interface FirstView {
  /** If empty, the volume or the scene determines the surfaces. */
  surfaces: readonly Surface[];
  /** If undefined, the viewer or the scene chooses the camera. */
  camera: Camera | undefined;
}

export interface Opened {
  /** The description of the first layer's store. */
  info: StoreInfo;
  /** Null if a single store was opened. */
  scene: ShownScene | null;
  /** Whether the viewer has the scene's surfaces. */
  hasSurfaces: boolean;
  /** The name of the scene. If empty, the title of its first layer is used. */
  title: string;
  /** Sentences for the visitor. */
  notes: string[];
}

/**
 * Opens the target of a page. `again`: bypasses caches, because cached data may have caused the
 * fault of the last attempt. Rejects with a StreamError, a RendererError or an AbortError.
 */
export function openTargetIn(
  viewer: Viewer,
  target: Target,
  url: UrlState,
  view: FirstView,
  again: boolean,
): Promise<Opened> {
  return "scene" in target
    ? openSceneIn(viewer, target, url, view)
    : openStoreIn(viewer, target, url, view, again);
}

async function openStoreIn(
  viewer: Viewer,
  target: StoreTarget,
  url: UrlState,
  { surfaces, camera }: FirstView,
  again: boolean,
): Promise<Opened> {
  const { projection } = url;
  const source = target.source();
  takeSpacing(source, url);
  if (again) source.bypassCaches();
  const info = await viewer.open(source, {
    ...(surfaces.length > 0 ? { surfaces } : {}),
    ...(camera ? { camera } : {}),
    ...(projection && { projection }),
  });
  return { info, scene: null, hasSurfaces: false, title: "", notes: [] };
}

/** The settings of the address take precedence over those of the scene. */
async function openSceneIn(
  viewer: Viewer,
  target: SceneTarget,
  url: UrlState,
  { surfaces, camera }: FirstView,
): Promise<Opened> {
  const [scene, { openScene }] = await Promise.all([
    target.scene(),
    import("../../scene/open_scene.ts"),
  ]);
  const shown = await openScene(viewer, scene);
  const { missing, layers, document } = shown;
  const { clip, slices, projection } = url;
  if (clip) viewer.setClip(clip);
  if (slices) viewer.setSlices(slices);
  viewer.setLook(lookOf(url));
  if (surfaces.length > 0) viewer.setSurfaces(surfaces);
  if (camera) viewer.setCamera(camera);
  else if (projection && !document.camera) viewer.setProjection(projection);
  const info = viewer.info ?? layers.find((layer) => layer?.info)?.info;
  if (!info) throw new Error(pageTexts.allHidden(target.name));
  const notes = missing.map(({ index, name, error }) =>
    pageTexts.layerMissing(name || String(index + 1), messageOf(error)),
  );
  // More sentences would cover the picture.
  return {
    info,
    scene: shown,
    hasSurfaces: surfaces.length === 0,
    title: document.name || target.name,
    notes: notes.slice(0, 3),
  };
}

/** The part of the look that the address states. */
function lookOf(url: UrlState): Partial<Look> {
  const { kind, shading, colourBy, colourMap, field, background, eyeDome, light } = url;
  return {
    ...(kind && { kind }),
    ...(shading && { shading }),
    ...(colourBy && { colourBy }),
    ...(colourMap && { colourMap }),
    ...(field && { field }),
    ...(background && { background }),
    ...(eyeDome !== undefined && { eyeDome }),
    ...(light && { light }),
  };
}
