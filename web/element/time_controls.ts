import { type ElementTexts, elementTexts } from "../texts/element.ts";
import { decimalSignOf } from "../texts/numbers.ts";
import type { Time } from "../viewer/time.ts";
import { type PlayMode, playModes } from "../viewer/time_order.ts";

export interface TimeControlsActions {
  setStep(step: number): void;
  setRate(rate: number): void;
  setLoop(mode: PlayMode): void;
  togglePlay(): void;
}

/** Steps per second to choose from, besides the present rate. */
const rates: readonly number[] = [1, 2, 5, 10, 20];

const svgNamespace = "http://www.w3.org/2000/svg";
const playPath = "M3 1v14l11-7z";
const pausePath = "M3 1h4v14H3zM9 1h4v14H9z";

/** The row of the controls for a scene that changes with time: a button that plays, a slider, and the time. */
export class TimeControls {
  readonly element = document.createElement("div");
  readonly #play = document.createElement("button");
  readonly #icon = document.createElementNS(svgNamespace, "path");
  readonly #slider = document.createElement("input");
  readonly #value = document.createElement("span");
  readonly #rate = document.createElement("select");
  readonly #loop = document.createElement("select");
  #texts: ElementTexts = elementTexts;
  #decimalSign = ".";
  #time: Time | null = null;

  constructor(actions: TimeControlsActions) {
    this.element.className = "time";
    this.element.hidden = true;
    this.#play.type = "button";
    this.#play.setAttribute("part", "button play");
    this.#play.addEventListener("click", actions.togglePlay);
    const picture = document.createElementNS(svgNamespace, "svg");
    picture.setAttribute("viewBox", "0 0 16 16");
    picture.setAttribute("aria-hidden", "true");
    picture.append(this.#icon);
    this.#play.append(picture);
    this.#slider.type = "range";
    this.#slider.min = "0";
    this.#slider.step = "1";
    this.#slider.setAttribute("part", "step");
    this.#slider.addEventListener("input", () => actions.setStep(Number(this.#slider.value)));
    this.#value.setAttribute("part", "time");
    this.#rate.setAttribute("part", "rate");
    this.#rate.addEventListener("change", () => actions.setRate(Number(this.#rate.value)));
    this.#loop.setAttribute("part", "loop");
    this.#loop.addEventListener("change", () => actions.setLoop(this.#loop.value as PlayMode));
    this.element.append(this.#play, this.#slider, this.#value, this.#rate, this.#loop);
    this.translate("en", elementTexts);
  }

  translate(language: string, texts: ElementTexts): void {
    this.#texts = texts;
    this.#decimalSign = decimalSignOf(language);
    this.#slider.setAttribute("aria-label", texts.time);
    name(this.#rate, texts.rate);
    name(this.#loop, texts.loop);
    offer(
      this.#loop,
      playModes.map((mode) => [mode, texts.loops[mode]]),
    );
    this.#rate.replaceChildren();
    this.show(this.#time);
  }

  /**
   * Shows the time of a viewer; null: the scene does not change with time. While an element has no viewer,
   * the last one stays.
   */
  show(time: Time | null): void {
    this.#time = time;
    this.element.hidden = time === null;
    if (!time) return;
    const { isPlaying, wantedStep, steps, values, unit } = time;
    this.#icon.setAttribute("d", isPlaying ? pausePath : playPath);
    this.#play.setAttribute("aria-label", isPlaying ? this.#texts.pause : this.#texts.play);
    this.#play.title = isPlaying ? this.#texts.pause : this.#texts.play;
    this.#slider.max = String(steps - 1);
    if (Number(this.#slider.value) !== wantedStep) this.#slider.value = String(wantedStep);
    const value = String(Number((values[wantedStep] ?? 0).toPrecision(6)));
    const text = `${value.replace(".", this.#decimalSign)}${unit && ` ${unit}`}`;
    this.#slider.setAttribute("aria-valuetext", text);
    this.#value.textContent = text;
    this.#showRate(time.rate);
    this.#loop.value = time.mode;
  }

  #showRate(rate: number): void {
    const value = String(rate);
    if (![...this.#rate.options].some((option) => option.value === value)) {
      const offered = [...new Set([...rates, rate])].sort((a, b) => a - b).map(String);
      offer(
        this.#rate,
        offered.map((each) => [each, `${each.replace(".", this.#decimalSign)}/s`]),
      );
    }
    this.#rate.value = value;
  }
}

function name(element: HTMLElement, text: string): void {
  element.setAttribute("aria-label", text);
  element.title = text;
}

/** choices: values with their texts. */
function offer(select: HTMLSelectElement, choices: readonly (readonly [string, string])[]): void {
  const { value } = select;
  select.replaceChildren(...choices.map(([each, text]) => new Option(text, each)));
  if (value) select.value = value;
}
