import type { StoreInfo } from "../core/types.ts";
import { type ElementTexts, elementTexts } from "../texts/element.ts";
import { decimalSignOf } from "../texts/numbers.ts";

export interface ControlsActions {
  setIsovalue(value: number): void;
  reset(): void;
  toggleFullScreen(): void;
}

/** The element's own controls: a slider and a field for the isovalue, and two buttons. */
export class ControlsBar {
  readonly element = document.createElement("div");
  readonly #slider = document.createElement("input");
  readonly #field = document.createElement("input");
  readonly #units = document.createElement("span");
  readonly #fit: HTMLButtonElement;
  readonly #fullScreen: HTMLButtonElement;
  #decimalSign = ".";
  #isovalue: number | undefined;

  constructor(actions: ControlsActions) {
    this.element.setAttribute("part", "controls");
    this.element.className = "controls";
    this.element.hidden = true;
    const set = (input: HTMLInputElement) => {
      const value = Number(input.value.replace(",", "."));
      if (input.value.trim() !== "" && Number.isFinite(value)) actions.setIsovalue(value);
    };

    this.#slider.type = "range";
    this.#slider.step = "any";
    this.#slider.setAttribute("part", "slider");
    this.#slider.addEventListener("input", () => set(this.#slider));

    this.#field.inputMode = "decimal";
    this.#field.autocomplete = "off";
    this.#field.setAttribute("part", "field");
    this.#field.addEventListener("change", () => set(this.#field));

    this.#units.setAttribute("part", "units");
    this.#fit = button(actions.reset);
    this.#fullScreen = button(actions.toggleFullScreen);
    const row = document.createElement("div");
    row.className = "row";
    row.append(this.#slider, this.#field, this.#units, this.#fit, this.#fullScreen);
    this.element.append(row);
    this.translate("en", elementTexts);
  }

  translate(language: string, texts: ElementTexts): void {
    this.#decimalSign = decimalSignOf(language);
    this.#slider.setAttribute("aria-label", texts.isovalue);
    this.#field.setAttribute("aria-label", texts.isovalueAsNumber);
    this.#fit.textContent = texts.fit;
    this.#fit.title = texts.fitTitle;
    this.#fullScreen.textContent = texts.fullScreen;
    this.#fullScreen.title = texts.fullScreenTitle;
    this.show(this.#isovalue);
  }

  /** Sets the range and the units of a volume. */
  opened({ range, metadata }: StoreInfo): void {
    [this.#slider.min, this.#slider.max] = [String(range[0]), String(range[1])];
    this.#units.textContent = metadata.units ?? "";
  }

  /** Shows an isovalue. Undefined: there is none yet, and the controls do not change. */
  show(isovalue: number | undefined): void {
    if (isovalue === undefined) return;
    this.#isovalue = isovalue;
    // At most six significant digits, without trailing zeros.
    const text = String(Number(isovalue.toPrecision(6))).replace(".", this.#decimalSign);
    if (Number(this.#slider.value) !== isovalue) this.#slider.value = String(isovalue);
    this.#slider.setAttribute("aria-valuetext", text);
    this.#field.value = text;
  }
}

function button(action: () => void): HTMLButtonElement {
  const element = document.createElement("button");
  element.type = "button";
  element.setAttribute("part", "button");
  element.addEventListener("click", action);
  return element;
}
