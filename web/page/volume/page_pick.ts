import { formatVolume } from "../../overlay/lengths.ts";
import { grouped } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";
import { listenToClicks } from "../../viewer/clicks.ts";
import type { SurfacePoint } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { formatField } from "../shell/format.ts";

/** The functions that a pick needs from its page. */
export interface PagePickHost {
  /** Whether clicks add points to measurements. */
  isMeasuring(): boolean;
  /** The title of a layer by its id; undefined if there is only one. */
  titleOfHit(layer: number): string | undefined;
  /** The title of the page. */
  title(): string;
  /** Shows a text to the visitor, and announces it. */
  show(text: string): void;
}

/**
 * Shows the name of the layer whose surface was clicked and, if the layer shows a label of a segmentation, the
 * volume and the number of voxels of the label; and the value of the field that colours show. Does nothing if the
 * picture has only one layer, without a label, and shows no field.
 */
export class PagePick {
  readonly #viewer: Viewer;
  readonly #host: PagePickHost;

  constructor(viewer: Viewer, host: PagePickHost) {
    this.#viewer = viewer;
    this.#host = host;
    const { canvas } = viewer;
    listenToClicks(canvas, ({ clientX, clientY }) => {
      const { left, top } = canvas.getBoundingClientRect();
      if (!host.isMeasuring()) this.#name(clientX - left, clientY - top);
    });
  }

  /** Names the layer in the middle of the picture, or states that there is no surface. */
  nameMiddle(): void {
    const { clientWidth, clientHeight } = this.#viewer.canvas;
    if (!this.#name(clientWidth / 2, clientHeight / 2)) this.#host.show(pageTexts.nothingThere);
  }

  /** Names the layer at a position on the canvas (CSS pixels). Returns false if there is nothing to name. */
  #name(x: number, y: number): boolean {
    const { layers, look } = this.#viewer;
    const isNamed = layers.length > 1 || layers[0]?.label;
    const point = isNamed || look.colourBy === "field" ? this.#viewer.pick(x, y) : undefined;
    const layer = layers.find(({ id }) => id === point?.layer);
    if (!point || !layer) return false;
    const title = this.#host.titleOfHit(layer.id) ?? (layer.name || this.#host.title());
    const label = layer.placedLabel;
    const size = label && [
      formatVolume(label.volume),
      pageTexts.voxels(grouped(label.voxels), label.voxels),
    ];
    const said = [...(isNamed ? [title] : []), ...(size ?? []), ...this.#fieldAt(point)];
    if (said.length === 0) return false;
    this.#host.show(said.join(" · "));
    return true;
  }

  /** The name and the value of the field that colours show. */
  #fieldAt({ field }: SurfacePoint): string[] {
    const { look, legend } = this.#viewer;
    if (field === undefined || look.colourBy !== "field") return [];
    if (Number.isNaN(field)) return [pageTexts.noFieldValue(look.field.name)];
    const label = legend?.categories?.find(({ value }) => value === field)?.name;
    const units = legend?.field?.units;
    return [formatField({ name: look.field.name, value: field, units, label })];
  }
}
