import type { StoreInfo } from "../core/types.ts";
import type { SceneSource } from "../scene/scene_source.ts";
import type { Source } from "../stream/source.ts";
import { StreamError } from "../stream/types.ts";
import { defaultLook } from "../viewer/types.ts";
import type { Viewer } from "../viewer/viewer.ts";
import type { ElementView } from "./element_view.ts";

/** The content that an element shows in addition to its child elements. Null if it shows only those. */
export type Content = { source: Source } | { scene: () => Promise<SceneSource> } | null;

export interface OpenedContent {
  /** The description of the first open layer. Null if all layers are hidden, or there are none yet. */
  info: StoreInfo | null;
  /** The layers of a scene that could not be opened. */
  missing: readonly Error[];
  /** Whether the scene states the camera. */
  hasCamera: boolean;
}

/**
 * Opens the content of an element, which replaces the present content of its viewer. Rejects with a StreamError, a
 * RendererError, or the signal's reason.
 */
export async function openContent(
  viewer: Viewer,
  content: Content,
  view: ElementView,
  signal: AbortSignal,
): Promise<OpenedContent> {
  if (!content) {
    viewer.close();
    return { info: null, missing: [], hasCamera: false };
  }
  if ("scene" in content) return openSceneIn(viewer, content.scene, view, signal);
  content.source.forget();
  const info = await viewer.open(content.source, { ...view.openOptions, signal });
  return { info, missing: [], hasCamera: false };
}

/** The settings of the element take precedence over those of the scene. */
async function openSceneIn(
  viewer: Viewer,
  load: () => Promise<SceneSource>,
  view: ElementView,
  signal: AbortSignal,
): Promise<OpenedContent> {
  const [scene, { openScene }] = await Promise.all([load(), import("../scene/open_scene.ts")]);
  signal.throwIfAborted();
  const { camera, look, time } = view;
  // Settings that the scene does not state have their defaults.
  viewer.setLook(defaultLook);
  const { document, layers, missing } = await openScene(viewer, scene, {
    step: (values) => time.firstOf(values),
    signal,
  });
  viewer.setLook(look);
  const { clip, slices } = view.chosen;
  if (clip) viewer.setClip(clip);
  if (slices) viewer.setSlices(slices);
  const { projection } = view.openOptions;
  if (camera) viewer.setCamera(camera);
  else if (projection && !document.camera) viewer.setProjection(projection);
  return {
    info: viewer.info ?? layers.find((layer) => layer?.info)?.info ?? null,
    missing: missing.map(({ index, name, error }) => missingLayer(name || `${index + 1}`, error)),
    hasCamera: document.camera !== null,
  };
}

function missingLayer(name: string, error: unknown): StreamError {
  const kind = error instanceof StreamError ? error.kind : "internal";
  const reason = error instanceof Error ? error.message : String(error);
  return new StreamError(kind, `the layer ${name} is missing: ${reason}`, error);
}
