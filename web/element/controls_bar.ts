import type { StoreInfo } from "../stream/index.ts";

export interface ControlsActions {
  setIsovalue(value: number): void;
  reset(): void;
  toggleFullScreen(): void;
}

/** At most six significant digits, without trailing zeros. */
function shown(value: number): string {
  return String(Number(value.toPrecision(6)));
}

/** The element's own controls: a slider and a field for the isovalue, and two buttons. */
export class ControlsBar {
  readonly element = document.createElement("div");
  readonly #slider = document.createElement("input");
  readonly #field = document.createElement("input");
  readonly #units = document.createElement("span");

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
    this.#slider.setAttribute("aria-label", "Isovalue");
    this.#slider.addEventListener("input", () => set(this.#slider));

    this.#field.inputMode = "decimal";
    this.#field.autocomplete = "off";
    this.#field.setAttribute("part", "field");
    this.#field.setAttribute("aria-label", "Isovalue as a number");
    this.#field.addEventListener("change", () => set(this.#field));

    this.#units.setAttribute("part", "units");
    this.element.append(
      this.#slider,
      this.#field,
      this.#units,
      button("Fit", "Show the whole volume", actions.reset),
      button("Full screen", "Show only this view", actions.toggleFullScreen),
    );
  }

  /** The range and the units of a volume. */
  opened({ range, metadata }: StoreInfo): void {
    [this.#slider.min, this.#slider.max] = [String(range[0]), String(range[1])];
    this.#units.textContent = metadata.units ?? "";
  }

  show(isovalue: number): void {
    const text = shown(isovalue);
    if (Number(this.#slider.value) !== isovalue) this.#slider.value = String(isovalue);
    this.#slider.setAttribute("aria-valuetext", text);
    this.#field.value = text;
  }
}

function button(text: string, label: string, action: () => void): HTMLButtonElement {
  const element = document.createElement("button");
  element.type = "button";
  element.textContent = text;
  element.title = label;
  element.setAttribute("part", "button");
  element.addEventListener("click", action);
  return element;
}
