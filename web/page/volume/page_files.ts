import type { StoreInfo } from "../../core/types.ts";
import type { Measurement } from "../../measure/measurement.ts";
import { layersTexts } from "../../texts/layers.ts";
import { pageTexts } from "../../texts/page.ts";
import { messageOf } from "../../texts/without_options.ts";
import { wholeVolume } from "../../viewer/clipping.ts";
import { identity, isIdentity } from "../../viewer/transform.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import type { CaptureDialog } from "../capture/capture_dialog.ts";
import type { MarkedPage } from "../capture/shown_marks.ts";
import type { SurfaceSettings } from "../panel/surface_settings.ts";
import { plainValue } from "../shell/format.ts";
import { theme, themeBackground } from "../shell/theme.ts";
import { keepThumbnailWhenIdle } from "../shell/thumbnails.ts";
import type { Toast } from "../shell/toast.ts";
import type { LayersPart } from "./layers_part.ts";

/** The files that a volume page saves: pictures, films and surfaces; and the picture for lists. */
export class PageFiles {
  readonly #viewer: Viewer;
  readonly #surfaces: SurfaceSettings;
  readonly #layers: LayersPart;
  readonly #toast: Toast;
  readonly #title: () => string;
  readonly #measurements: MarkedPage["measurements"];
  #capture: Promise<CaptureDialog> | null = null;
  #keptThumbnail = "";

  /** `title`: the volume's title, for file names. `measurements`: those of the picture. */
  constructor(
    viewer: Viewer,
    surfaces: SurfaceSettings,
    layers: LayersPart,
    toast: Toast,
    { title, measurements }: Pick<MarkedPage, "title" | "measurements">,
  ) {
    this.#viewer = viewer;
    this.#surfaces = surfaces;
    this.#layers = layers;
    this.#toast = toast;
    this.#title = title;
    this.#measurements = measurements;
  }

  /** Offers a file to save, whose name begins with the volume's name. */
  save(ending: string, content: Blob): void {
    download(`${this.#fileName}-${ending}`, content);
  }

  get #fileName(): string {
    return this.#title().replace(/[^\w.-]+/g, "-");
  }

  /**
   * Saves the document of a scene. A message names the layers that it lacks, because they have no
   * address.
   */
  async saveScene(
    { isThemeBackground }: { isThemeBackground: boolean },
    loading: Promise<readonly Measurement[]>,
  ): Promise<void> {
    try {
      const measurements = await loading;
      const { writeScene } = await import("../../scene/write_scene.ts");
      const layers = this.#layers;
      const { look } = this.#viewer;
      const { text, left } = writeScene(this.#viewer, {
        name: this.#title(),
        scene: layers.scene,
        measurements,
        nameOf: (layer) => layers.titleOf(layer),
        hasBackground: !isThemeBackground || look.background !== themeBackground[theme()],
      });
      if (text === null) {
        this.#toast.note(layersTexts.notSaved);
        return;
      }
      const file = `${this.#fileName.replace(/\.(isobundle|isosplat|scene\.json)$/i, "")}.scene.json`;
      download(file, new Blob([text], { type: "application/json" }));
      const names = left.map((layer) => layers.titleOf(layer)).join(", ");
      if (left.length === 0) this.#toast.done(layersTexts.saved(file));
      else this.#toast.note(layersTexts.savedWithout(file, names, left.length));
    } catch {
      this.#toast.note(pageTexts.noSaving);
    }
  }

  async saveScreenshot(options: { transparent?: boolean } = {}): Promise<void> {
    try {
      const picture = await this.#viewer.screenshot(options);
      this.save(`${this.#isovalues}.png`, picture);
      this.#toast.done(pageTexts.pictureSaved);
    } catch (error) {
      this.#toast.note(error instanceof Error ? messageOf(error) : pageTexts.noPicture);
    }
  }

  /** `enterSpacing`: asks for the distances between voxels of a volume that is alone in the picture. */
  async saveSurface(enterSpacing: () => void): Promise<void> {
    const { surfaces, active } = this.#surfaces.state;
    const { isovalue } = surfaces[active] ?? {};
    const access = (this.#layers.chosen ?? this.#viewer).storeAccess;
    if (isovalue === undefined || !access) return;
    const isAlone = !this.#layers.scene && !this.#layers.chosen;
    try {
      const { openSurfaceDialog } = await import("../capture/surface_dialog.ts");
      // The clip box is a fraction of the first layer.
      const clip = this.#surfaces.subject ? wholeVolume : this.#viewer.clip;
      const { transform = identity } = this.#layers.chosen ?? {};
      if (!isIdentity(transform)) this.#toast.note(pageTexts.savedUnmoved);
      openSurfaceDialog(access, isovalue, clip, {
        save: (ending, file) => this.save(`${isovalue}.${ending}`, file),
        ...(isAlone && { enterSpacing }),
      });
    } catch {
      this.#toast.note(pageTexts.noSaving);
    }
  }

  async openCapture(): Promise<void> {
    try {
      this.#capture ??= import("../capture/capture_dialog.ts").then(
        ({ CaptureDialog }) =>
          new CaptureDialog({
            viewer: this.#viewer,
            title: this.#title,
            measurements: this.#measurements,
            // A film changes the isovalue of the first layer.
            activeSurface: () => (this.#surfaces.subject ? 0 : this.#surfaces.state.active),
            save: (ending, content) => this.save(`${this.#isovalues}-${ending}`, content),
          }),
      );
      await (await this.#capture).open();
    } catch {
      this.#capture = null;
      this.#toast.note(pageTexts.noDialog);
    }
  }

  /** Keeps the present picture for lists of volumes, unless it was kept already. */
  keepThumbnail({ contentId }: StoreInfo): void {
    // A picture of several volumes is not that of the first one.
    if (this.#layers.scene || this.#viewer.layers.length > 1) return;
    if (this.#keptThumbnail === contentId) return;
    this.#keptThumbnail = contentId;
    keepThumbnailWhenIdle(contentId, () => this.#viewer.screenshot({ smooth: false }));
  }

  get #isovalues(): string {
    return this.#surfaces.first.map((surface) => plainValue(surface.isovalue)).join("-");
  }
}

function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
