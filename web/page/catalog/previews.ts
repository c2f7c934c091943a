import { wholeVolume } from "../../viewer/clipping.ts";
import { RendererError } from "../../viewer/renderer_error.ts";
import { noSlices } from "../../viewer/slices.ts";
import { surfacesAt } from "../../viewer/surfaces.ts";
import { defaultLook } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { firstIsovalue } from "../panel/isovalue_scale.ts";
import { savesData, whenDrawn, withHiddenViewer } from "../shell/hidden_viewer.ts";
import { sceneSource, volumeSource } from "../shell/site.ts";
import { theme, themeBackground } from "../shell/theme.ts";
import { keepThumbnail, pictureSize, thumbnail } from "../shell/thumbnails.ts";

/**
 * A volume whose first surface takes longer (ms) keeps its histogram. Refinement stops after
 * `refining`.
 */
const longest = { firstSurface: 20_000, refining: 3_000 };
/** The camera is closer than in the view of the whole volume, since surfaces seldom reach its corners. */
const zoom = 1.25;

/** Scenes with more layers keep their icon, because their headers alone are large. */
const mostLayers = 128;

/** A volume or a scene that needs a picture. */
export interface WithoutPicture {
  name: string;
  contentId: string;
  /** The number of layers of a scene; undefined: it is a volume. */
  layers?: number;
}

/**
 * Draws pictures of volumes and scenes that have none in this browser, one after another: volumes at their first
 * isovalue, scenes in their first view. Each takes about 100 to 700 KB. Does nothing if the browser saves data.
 */
export class Previews {
  readonly #onThumbnail: () => void;
  readonly #waiting = new Map<string, WithoutPicture>();
  readonly #tried = new Set<string>();
  #isRunning = false;

  /** `onThumbnail`: called when there is a new `thumbnail`. */
  constructor(onThumbnail: () => void) {
    this.#onThumbnail = onThumbnail;
  }

  request(wanted: WithoutPicture): void {
    const { contentId, layers = 1 } = wanted;
    if (layers > mostLayers) return;
    if (savesData() || this.#tried.has(contentId) || thumbnail(contentId)) return;
    this.#waiting.set(contentId, wanted);
    if (!this.#isRunning) void this.#run();
  }

  async #run(): Promise<void> {
    this.#isRunning = true;
    try {
      await withHiddenViewer(pictureSize, { maxPixelRatio: 1, targetCellPixels: 2 }, (viewer) =>
        this.#drawAll(viewer),
      );
    } catch {
      this.#waiting.clear(); // without WebGL 2, cards show histograms
    } finally {
      this.#isRunning = false;
    }
  }

  async #drawAll(viewer: Viewer): Promise<void> {
    for (const [contentId, wanted] of this.#waiting) {
      this.#waiting.delete(contentId);
      this.#tried.add(contentId);
      if (await this.#draw(viewer, wanted)) {
        await keepThumbnail(contentId, await viewer.screenshot({ smooth: false }));
        this.#onThumbnail();
      }
      viewer.close();
    }
  }

  /** Resolves to whether the first surface was drawn. */
  async #draw(viewer: Viewer, wanted: WithoutPicture): Promise<boolean> {
    const picture = whenDrawn(viewer, longest);
    try {
      const hasCamera = await open(viewer, wanted);
      if (viewer.camera && !hasCamera) {
        viewer.setCamera({ ...viewer.camera, distance: viewer.camera.distance / zoom });
      }
      return await picture.drawn;
    } catch (error) {
      if (error instanceof RendererError) throw error;
      return false; // the volume's own page reports the error
    } finally {
      picture.stop();
    }
  }
}

/** Opens a volume or a scene. Resolves to true if it is a scene that states a camera. */
async function open(viewer: Viewer, { name, layers }: WithoutPicture): Promise<boolean> {
  // Reset the settings of the previous scene.
  viewer.setLook({ ...defaultLook, background: themeBackground[theme()] });
  viewer.setClip(wholeVolume);
  viewer.setSlices(noSlices);
  if (layers !== undefined) {
    const [source, { openScene }] = await Promise.all([
      sceneSource(name),
      import("../../scene/open_scene.ts"),
    ]);
    const { document } = await openScene(viewer, source);
    return document.camera !== null;
  }
  viewer.setSurfaces([]);
  const info = await viewer.open(volumeSource(name));
  viewer.setSurfaces(surfacesAt([firstIsovalue(info)]));
  return false;
}
