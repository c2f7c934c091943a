import { html, nothing, type TemplateResult } from "lit";
import { bitRate, canEncode } from "../../capture/video_rate.ts";
import { captureTexts } from "../../texts/capture.ts";
import type { PictureSize } from "../../viewer/types.ts";
import { formatBytes } from "../shell/format.ts";
import { numberField } from "../shell/number_field.ts";
import {
  type CaptureSettings,
  chosenSize,
  frameCount,
  sizeChoices,
  type What,
} from "./capture_settings.ts";
import type { MarkName } from "./shown_marks.ts";

export interface FormActions {
  change(settings: Partial<CaptureSettings>): void;
  /** Adds the present view to the path. */
  addView(): void;
}

/** The fields of the dialog for pictures and films. */
export function captureFields(
  settings: CaptureSettings,
  shown: PictureSize,
  hasTime: boolean,
  offered: readonly MarkName[],
  { change, addView }: FormActions,
): TemplateResult {
  const { what, sizeName, own, cameras, format, framesPerSecond, seconds, from, to } = settings;
  const sizes = [
    ...sizeChoices(shown).map(({ name, label, size }) => ({
      value: name,
      label: `${label}: ${size.width} × ${size.height}`,
    })),
    { value: "own", label: captureTexts.otherSize },
  ];
  const isFilm = what !== "picture";
  return html`${select(captureTexts.what, what, whats(hasTime), (value) => change({ what: value }))}
    ${
      what === "sweep"
        ? html`<div class="row">
            ${numberField(captureTexts.from, from, (value) => change({ from: value }))}
            ${numberField(captureTexts.to, to, (value) => change({ to: value }))}
          </div>`
        : nothing
    }
    ${
      what === "path"
        ? html`<div class="capture-views">
            <span>${captureTexts.views(cameras.length)}</span>
            <button type="button" class="chip" @click=${addView}>${captureTexts.addView}</button>
            <button
              type="button"
              class="chip"
              ?disabled=${cameras.length === 0}
              @click=${() => change({ cameras: [] })}
            >
              ${captureTexts.removeAll}
            </button>
          </div>`
        : nothing
    }
    ${select(captureTexts.size, sizeName, sizes, (value) => change({ sizeName: value }))}
    ${
      sizeName === "own"
        ? html`<div class="row">
            ${numberField(captureTexts.width, own.width, (width) => change({ own: { ...own, width } }), whole)}
            ${numberField(captureTexts.height, own.height, (height) => change({ own: { ...own, height } }), whole)}
          </div>`
        : nothing
    }
    ${
      isFilm
        ? html`<div class="row">
              ${numberField(captureTexts.seconds, seconds, (value) => change({ seconds: value }))}
              ${select(captureTexts.framesPerSecond, String(framesPerSecond), rates, (value) =>
                change({ framesPerSecond: Number(value) }),
              )}
            </div>
            ${select(captureTexts.file, format, formats(), (value) => change({ format: value }))}`
        : html`${check(captureTexts.transparent, settings.transparent, (transparent) => change({ transparent }))}
            ${select(captureTexts.file, settings.pictureFormat, pictureFormats, (value) =>
              change({ pictureFormat: value }),
            )}`
    }
    <fieldset class="capture-marks">
      <legend>${captureTexts.marks}</legend>
      ${offered.map((name) =>
        check(captureTexts.markNames[name], settings.marks.has(name), (isChosen) => {
          const marks = new Set(settings.marks);
          if (isChosen) marks.add(name);
          else marks.delete(name);
          change({ marks });
        }),
      )}
    </fieldset>`;
}

function check(
  label: string,
  checked: boolean,
  change: (checked: boolean) => void,
): TemplateResult {
  return html`<label class="check">
    <input
      type="checkbox"
      .checked=${checked}
      @change=${(event: Event) => change((event.currentTarget as HTMLInputElement).checked)}
    />
    ${label}
  </label>`;
}

/** The expected size of the film. */
export function forecast(settings: CaptureSettings, shown: PictureSize): string {
  if (settings.what === "picture") return "";
  const frames = captureTexts.frames(frameCount(settings));
  if (settings.format === "png" || settings.format === "gif") return frames;
  const bits = bitRate(chosenSize(settings, shown), settings.framesPerSecond) * settings.seconds;
  return captureTexts.atMost(frames, formatBytes(bits / 8));
}

const pictureFormats = [
  { value: "png", label: "PNG" },
  { value: "svg", label: captureTexts.svg },
] as const;
const whole = { isWhole: true };
const rates = ["24", "30", "60"].map((value) => ({ value, label: value }));
function whats(hasTime: boolean): { value: What; label: string }[] {
  const always: What[] = ["picture", "turntable", "sweep", "path"];
  const all: What[] = hasTime ? [...always, "time"] : always;
  return all.map((value) => ({ value, label: captureTexts.whats[value] }));
}

function formats() {
  const pictures = [
    { value: "gif", label: captureTexts.gif },
    { value: "png", label: captureTexts.pngs },
  ] as const;
  if (!canEncode()) return pictures;
  return [
    { value: "mp4", label: captureTexts.mp4 },
    { value: "webm", label: captureTexts.webm },
    ...pictures,
  ] as const;
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
