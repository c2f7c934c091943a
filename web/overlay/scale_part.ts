import type { StoreInfo, Triple } from "../core/types.ts";
import type { OverlayTexts } from "../texts/overlay.ts";
import { unitOf } from "./length_unit.ts";
import { formatLength, scaleBar } from "./lengths.ts";
import type { Screen } from "./screen.ts";

const longestBar = 140;

/** A scale bar whose length is a round number. It is exact at the distance of the centre of rotation. */
export class ScalePart {
  readonly element = document.createElement("div");
  readonly #bar = document.createElement("div");
  readonly #text = document.createTextNode("");

  readonly #texts: OverlayTexts;

  constructor(texts: OverlayTexts) {
    this.#texts = texts;
    this.element.className = "overlay-scale";
    this.element.setAttribute("role", "img");
    this.element.title = texts.scaleTitle;
    this.#bar.className = "overlay-scale-bar";
    this.element.append(this.#bar, this.#text);
  }

  draw(info: StoreInfo, screen: Screen, target: Triple): void {
    const bar = scaleBar(screen.pixelsPerUnit(target), longestBar);
    this.element.hidden = !bar;
    if (!bar) return;
    const text = formatLength(bar.mm, unitOf(info), this.#texts);
    this.#bar.style.width = `${bar.pixels}px`;
    if (this.#text.data === text) return;
    this.#text.data = text;
    this.element.setAttribute("aria-label", this.#texts.scale(text));
  }
}
