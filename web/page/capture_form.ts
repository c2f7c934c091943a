import { html, nothing, type TemplateResult } from "lit";
import { mostPixels } from "../capture/picture.ts";
import { bitRate, canEncode } from "../capture/webm_file.ts";
import type { PictureSize } from "../viewer/index.ts";
import { type CaptureSettings, chosenSize, frameCount, sizeChoices } from "./capture_settings.ts";
import { formatBytes } from "./format.ts";

export interface FormActions {
  change(settings: Partial<CaptureSettings>): void;
  /** Adds the present view to the path. */
  addView(): void;
}

/** The fields of the dialog of pictures and films. */
export function captureFields(
  settings: CaptureSettings,
  shown: PictureSize,
  { change, addView }: FormActions,
): TemplateResult {
  const { what, sizeName, own, cameras, format, framesPerSecond, seconds, from, to } = settings;
  const sizes = [
    ...sizeChoices(shown).map(({ name, size }) => ({
      value: name,
      label: `${name}: ${size.width} × ${size.height}`,
    })),
    { value: "own", label: "Other …" },
  ];
  const isFilm = what !== "picture";
  return html`${select("What", what, whats, (value) => change({ what: value }))}
    ${
      what === "sweep"
        ? html`<div class="row">
            ${number("From isovalue", from, {}, (value) => change({ from: value }))}
            ${number("To isovalue", to, {}, (value) => change({ to: value }))}
          </div>`
        : nothing
    }
    ${
      what === "path"
        ? html`<div class="capture-views">
            <span>${cameras.length === 1 ? "1 view" : `${cameras.length} views`}</span>
            <button type="button" class="chip" @click=${addView}>Add this view</button>
            <button
              type="button"
              class="chip"
              ?disabled=${cameras.length === 0}
              @click=${() => change({ cameras: [] })}
            >
              Remove all
            </button>
          </div>`
        : nothing
    }
    ${select("Size in pixels", sizeName, sizes, (value) => change({ sizeName: value }))}
    ${
      sizeName === "own"
        ? html`<div class="row">
            ${number("Width", own.width, pixels, (width) => change({ own: { ...own, width } }))}
            ${number("Height", own.height, pixels, (height) => change({ own: { ...own, height } }))}
          </div>`
        : nothing
    }
    ${
      isFilm
        ? html`<div class="row">
              ${number("Seconds", seconds, { min: 0.1 }, (value) => change({ seconds: value }))}
              ${select("Frames per second", String(framesPerSecond), rates, (value) =>
                change({ framesPerSecond: Number(value) }),
              )}
            </div>
            ${select("File", format, formats(), (value) => change({ format: value }))}`
        : html`<label class="check">
            <input
              type="checkbox"
              .checked=${settings.transparent}
              @change=${(event: Event) =>
                change({ transparent: (event.currentTarget as HTMLInputElement).checked })}
            />
            Without background (transparent)
          </label>`
    }`;
}

/** How large the film will be. */
export function forecast(settings: CaptureSettings, shown: PictureSize): string {
  if (settings.what === "picture") return "";
  const frames = `${frameCount(settings)} frames`;
  if (settings.format === "png") return frames;
  const bits = bitRate(chosenSize(settings, shown), settings.framesPerSecond) * settings.seconds;
  return `${frames}, at most about ${formatBytes(bits / 8)}`;
}

const pixels = { min: 1, max: mostPixels };
const rates = ["24", "30", "60"].map((value) => ({ value, label: value }));
const whats = [
  { value: "picture", label: "Picture" },
  { value: "turntable", label: "Film: once around" },
  { value: "sweep", label: "Film: through isovalues" },
  { value: "path", label: "Film: from view to view" },
] as const;

function formats() {
  const png = { value: "png", label: "PNG files in a ZIP" } as const;
  return canEncode() ? ([{ value: "webm", label: "WebM video" }, png] as const) : [png];
}

function select<Value extends string>(
  label: string,
  value: Value,
  options: readonly { value: Value; label: string }[],
  change: (value: Value) => void,
): TemplateResult {
  return html`<label>
    ${label}
    <select
      @change=${(event: Event) => change((event.currentTarget as HTMLSelectElement).value as Value)}
    >
      ${options.map(
        (option) =>
          html`<option value=${option.value} ?selected=${option.value === value}>
            ${option.label}
          </option>`,
      )}
    </select>
  </label>`;
}

function number(
  label: string,
  value: number,
  { min, max }: { min?: number; max?: number },
  change: (value: number) => void,
): TemplateResult {
  return html`<label>
    ${label}
    <input
      type="number"
      step="any"
      min=${min ?? nothing}
      max=${max ?? nothing}
      inputmode="decimal"
      .value=${Number.isNaN(value) ? "" : String(value)}
      @input=${(event: Event) => change((event.currentTarget as HTMLInputElement).valueAsNumber)}
    />
  </label>`;
}
