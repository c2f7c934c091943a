import "./time.css";
import { html, nothing, render, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import { timeTexts } from "../../texts/time.ts";
import type { Time } from "../../viewer/time.ts";
import { type PlayMode, playModes } from "../../viewer/time_order.ts";
import { iconButton } from "../shell/chrome.ts";
import { formatBytes, formatValue } from "../shell/format.ts";

/** Steps per second to choose from. */
const rates: readonly number[] = [1, 2, 5, 10, 20];

/** The bar below the picture of a scene that changes with time. */
export class TimeBar {
  readonly element = document.createElement("section");
  readonly #time: Time;
  readonly #ends: (() => void)[];
  #handle = 0;

  constructor(time: Time) {
    this.#time = time;
    this.element.className = "time-bar";
    this.element.setAttribute("aria-label", timeTexts.time);
    const request = () => this.request();
    this.#ends = (["step", "play", "buffering", "change"] as const).map((name) =>
      time.on(name, request),
    );
    this.renderNow();
  }

  close(): void {
    cancelAnimationFrame(this.#handle);
    for (const end of this.#ends) end();
    this.element.remove();
  }

  /** Renders in the next frame: `cost` may have changed. */
  request(): void {
    if (this.#handle === 0) this.#handle = requestAnimationFrame(() => this.renderNow());
  }

  renderNow(): void {
    cancelAnimationFrame(this.#handle);
    this.#handle = 0;
    const time = this.#time;
    const { isPlaying, wantedStep, steps } = time;
    render(
      html`<div class="time-row">
          ${iconButton({ icon: "previous", label: timeTexts.back, action: () => this.step(-1) })}
          ${iconButton({
            icon: isPlaying ? "pause" : "play",
            label: isPlaying ? timeTexts.pause : timeTexts.play,
            action: () => this.togglePlay(),
          })}
          ${iconButton({ icon: "next", label: timeTexts.forth, action: () => this.step(1) })}
          <input
            type="range"
            class="time-slider"
            aria-label=${timeTexts.time}
            aria-valuetext=${`${this.#value(wantedStep)}, ${timeTexts.step(wantedStep + 1, steps)}`}
            min="0"
            max=${steps - 1}
            step="1"
            .valueAsNumber=${live(wantedStep)}
            @input=${(event: Event) => this.#set((event.currentTarget as HTMLInputElement).valueAsNumber)}
          />
          <output class="time-value">${this.#value(wantedStep)}</output>
        </div>
        <div class="time-row quiet">
          ${choice(timeTexts.rate, rateChoices(time.rate), String(time.rate), (rate) => {
            time.rate = Number(rate);
          })}
          ${choice(timeTexts.order, modeChoices(), time.mode, (mode) => {
            time.mode = mode as PlayMode;
          })}
          <span class="time-step">${timeTexts.step(wantedStep + 1, steps)}</span>
          <span class="time-cost" title=${timeTexts.costTitle}>${this.#cost}</span>
          <span class="time-waits" role="status">${time.isBuffering ? timeTexts.waits : nothing}</span>
        </div>`,
      this.element,
    );
  }

  togglePlay(): void {
    if (this.#time.isPlaying) this.#time.pause();
    else this.#time.play();
  }

  /** Moves by one step, and wraps around at both ends. Stops playing. */
  step(by: 1 | -1): void {
    const { wantedStep, steps } = this.#time;
    this.#set((wantedStep + by + steps) % steps);
  }

  #set(step: number): void {
    this.#time.pause();
    void this.#time.setStep(step);
    this.request();
  }

  #value(step: number): string {
    const { values, unit } = this.#time;
    const value = formatValue(values[step] ?? 0);
    return unit ? `${value} ${unit}` : value;
  }

  get #cost(): string {
    const { cost, cellPixels, isPlaying } = this.#time;
    if (isPlaying && cellPixels > 1) return timeTexts.coarser;
    if (!cost) return "";
    const bytes = formatBytes(cost.bytes);
    const stated = cost.isEstimated ? timeTexts.about(bytes) : bytes;
    return timeTexts.atFullDetail(timeTexts.cost(cost.steps, stated));
  }
}

interface Choice {
  value: string;
  label: string;
}

function rateChoices(rate: number): Choice[] {
  return [...new Set([...rates, rate])]
    .sort((a, b) => a - b)
    .map((each) => ({ value: String(each), label: timeTexts.rates(formatValue(each)) }));
}

function modeChoices(): Choice[] {
  return playModes.map((mode) => ({ value: mode, label: timeTexts.modes[mode] }));
}

function choice(
  label: string,
  choices: readonly Choice[],
  chosen: string,
  choose: (value: string) => void,
): TemplateResult {
  return html`<select
    aria-label=${label}
    title=${label}
    @change=${(event: Event) => choose((event.currentTarget as HTMLSelectElement).value)}
  >
    ${choices.map(
      (each) =>
        html`<option value=${each.value} ?selected=${each.value === chosen}>${each.label}</option>`,
    )}
  </select>`;
}
