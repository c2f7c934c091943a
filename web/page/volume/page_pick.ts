import { formatVolume } from "../../overlay/lengths.ts";
import { grouped } from "../../texts/numbers.ts";
import { pageTexts } from "../../texts/page.ts";
import { listenToClicks } from "../../viewer/clicks.ts";
import type { Viewer } from "../../viewer/viewer.ts";

/** The functions that a pick needs from its page. */
export interface PagePickHost {
  /** Whether clicks are points of measurements. */
  isMeasuring(): boolean;
  /** The title of a layer by its id; undefined if there is only one. */
  titleOfHit(layer: number): string | undefined;
  /** The title of the page. */
  title(): string;
  /** Shows a text to the visitor, and announces it. */
  says(text: string): void;
}

/**
 * Names the layer whose surface was clicked, with the volume of its label. In a picture of one volume without
 * a label, nothing is said.
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

  /** Names what is in the middle of the picture. */
  nameMiddle(): void {
    const { clientWidth, clientHeight } = this.#viewer.canvas;
    if (!this.#name(clientWidth / 2, clientHeight / 2)) this.#host.says(pageTexts.nothingThere);
  }

  /** Returns whether there is a surface at this position on the canvas, in CSS pixels. */
  #name(x: number, y: number): boolean {
    const { layers } = this.#viewer;
    const isNamed = layers.length > 1 || layers[0]?.label;
    const point = isNamed ? this.#viewer.pick(x, y) : undefined;
    const layer = layers.find(({ id }) => id === point?.layer);
    if (!point || !layer) return false;
    const title = this.#host.titleOfHit(layer.id) ?? (layer.name || this.#host.title());
    const label = layer.placedLabel;
    const size = label && [
      formatVolume(label.volume),
      pageTexts.voxels(grouped(label.voxels), label.voxels),
    ];
    this.#host.says([title, ...(size ?? [])].join(" · "));
    return true;
  }
}
