import "./capture.css";
import { html, nothing, render } from "lit";
import { captureFilm, type FilmFile } from "../../capture/film.ts";
import { svgWithPicture } from "../../capture/marked_pixels.ts";
import { type CaptureProgress, capturePng } from "../../capture/picture.ts";
import { pngSequence } from "../../capture/png_sequence.ts";
import { canEncode } from "../../capture/video_rate.ts";
import { captureTexts } from "../../texts/capture.ts";
import { pageTexts } from "../../texts/page.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { Camera, PictureSize } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { formatBytes, formatDuration } from "../shell/format.ts";
import { askBeforeLeaving, keepOpen } from "../shell/keep_open.ts";
import { captureFields, forecast } from "./capture_form.ts";
import { type CaptureSettings, chosenSize, framesOf, problemOf } from "./capture_settings.ts";
import { type MarkedPage, offeredMarks, shownMarks } from "./shown_marks.ts";

type Dialog = HTMLElement & { open: boolean };

export interface CaptureHost extends MarkedPage {
  /** The surface whose isovalue the panel shows. */
  activeSurface(): number;
  /** Saves a file whose name begins with the volume's name. */
  save(ending: string, content: Blob): void;
}

/** Seconds of drawing after which the rest can be estimated. */
const leastMeasured = 2;

/** The dialog that saves pictures of any size, and films. */
export class CaptureDialog {
  readonly #host: CaptureHost;
  readonly #holder = document.createElement("div");
  #settings: CaptureSettings;
  #running: AbortController | null = null;
  #progress: CaptureProgress = {};
  /** When drawing began (ms); 0: not yet. */
  #drawingSince = 0;
  #message = "";

  constructor(host: CaptureHost) {
    this.#host = host;
    const [from, to] = host.viewer.info?.range ?? [0, 1];
    this.#settings = {
      what: "picture",
      sizeName: "shown",
      own: { width: 4096, height: 4096 },
      transparent: false,
      marks: new Set(),
      pictureFormat: "png",
      seconds: 6,
      framesPerSecond: 30,
      format: canEncode() ? "webm" : "png",
      from,
      to,
      cameras: [],
    };
  }

  async open(): Promise<void> {
    await import("../shell/components.ts");
    document.body.append(this.#holder);
    this.#message = "";
    this.#render();
    (this.#holder.firstElementChild as Dialog).open = true;
  }

  #change(change: Partial<CaptureSettings>): void {
    this.#settings = { ...this.#settings, ...change };
    this.#message = "";
    this.#render();
  }

  #addView(): void {
    const { camera } = this.#host.viewer;
    if (camera) this.#change({ cameras: [...this.#settings.cameras, camera] });
  }

  #render(): void {
    const settings = this.#settings;
    const { canvas } = this.#host.viewer;
    const isRunning = this.#running !== null;
    const problem = problemOf(settings, canvas);
    const text = isRunning ? this.#progressText : this.#message || forecast(settings, canvas);
    render(
      html`<wa-dialog
        label=${captureTexts.title}
        @wa-hide=${(event: Event) => keepOpen(event, isRunning)}
        @wa-after-hide=${(event: Event) => {
          if (event.target === this.#holder.firstElementChild) this.#running?.abort();
        }}
      >
        <form
          class="capture-form"
          @submit=${(event: Event) => {
            event.preventDefault();
            if (!problem && !isRunning) void this.#run();
          }}
        >
          <fieldset ?disabled=${isRunning}>
            ${captureFields(
              settings,
              canvas,
              this.#host.viewer.time !== null,
              offeredMarks(this.#host),
              {
                change: (change) => this.#change(change),
                addView: () => this.#addView(),
              },
            )}
          </fieldset>
          ${isRunning ? this.#progressPart() : nothing}
          <p role="status" class=${problem ? "" : "quiet"}>${problem ?? text}</p>
          <div class="capture-actions">
            ${
              isRunning
                ? html`<wa-button
                    class="cancel"
                    size="s"
                    appearance="outlined"
                    @click=${() => this.#running?.abort()}
                    >${captureTexts.cancel}</wa-button
                  >`
                : html`<wa-button
                    type="submit"
                    variant="brand"
                    size="s"
                    ?disabled=${problem !== undefined}
                    >${captureTexts.save}</wa-button
                  >`
            }
          </div>
        </form>
      </wa-dialog>`,
      this.#holder,
    );
  }

  #progressPart() {
    const { share } = this.#progress;
    return share === undefined
      ? html`<progress aria-label=${captureTexts.saving}></progress>`
      : html`<progress aria-label=${captureTexts.saving} max="1" .value=${share}></progress>`;
  }

  get #progressText(): string {
    const { share, bytesToGo } = this.#progress;
    if (share !== undefined) {
      const seconds = (performance.now() - this.#drawingSince) / 1000;
      const left = (seconds * (1 - share)) / share;
      const isKnown = share > 0 && seconds > leastMeasured;
      const text = captureTexts.drawing(Math.round(100 * share));
      return isKnown ? `${text} · ${pageTexts.left(formatDuration(left))}` : text;
    }
    return bytesToGo ? captureTexts.fetching(formatBytes(bytesToGo)) : captureTexts.preparing;
  }

  async #run(): Promise<void> {
    const running = new AbortController();
    this.#running = running;
    this.#progress = {};
    this.#drawingSince = 0;
    this.#render();
    const stopAsking = askBeforeLeaving();
    try {
      const { ending, content } = await this.#capture(running.signal);
      this.#host.save(ending, content);
      this.#message = `${captureTexts.saved(formatBytes(content.size))} ${shortcoming(this.#host.viewer)}`;
    } catch (error) {
      if (running.signal.aborted) this.#message = captureTexts.cancelled;
      else this.#message = messageOf(error);
    }
    stopAsking();
    this.#running = null;
    this.#render();
  }

  async #capture(signal: AbortSignal): Promise<{ ending: string; content: Blob }> {
    const { viewer, activeSurface } = this.#host;
    const settings = this.#settings;
    const size = chosenSize(settings, viewer.canvas);
    const progress = (now: CaptureProgress): void => {
      this.#progress = now;
      if (now.share !== undefined) this.#drawingSince ||= performance.now();
      this.#render();
    };
    const { what, format, framesPerSecond, transparent, marks: chosen, pictureFormat } = settings;
    const marks = (camera?: Camera) =>
      shownMarks(this.#host, chosen, size, transparent && what === "picture", camera);
    if (what === "picture") {
      const isSvg = pictureFormat === "svg";
      const options = { transparent, signal, progress, ...(!isSvg && { marks: () => marks() }) };
      const png = await capturePng(viewer, size, options);
      const content = isSvg ? await svgWithPicture(png, size, marks()) : png;
      return { ending: `${size.width}x${size.height}.${pictureFormat}`, content };
    }
    const { camera, surfaces } = viewer;
    if (!camera) throw new Error(captureTexts.noPicture);
    const steps = viewer.time?.steps ?? 1;
    const frames = framesOf(settings, { camera, surfaces }, activeSurface(), steps);
    const file = await filmFile(format, size, framesPerSecond);
    const content = await captureFilm(viewer, size, frames, file, { signal, progress, marks });
    return { ending: `${what}.${format === "png" ? "zip" : format}`, content };
  }
}

/** The code of the format is loaded at its first use. */
async function filmFile(
  format: CaptureSettings["format"],
  size: PictureSize,
  framesPerSecond: number,
): Promise<FilmFile> {
  if (format === "png") return pngSequence(size);
  if (format === "gif") {
    const { gifFile } = await import("../../capture/gif_file.ts");
    return gifFile(size, framesPerSecond);
  }
  const { videoFile } = await import("../../capture/video_file.ts");
  return videoFile(format, size, framesPerSecond);
}

/** The shortcomings of the picture, in a sentence; empty if there are none. */
function shortcoming(viewer: Viewer): string {
  switch (viewer.progress?.state) {
    case "limited":
      return captureTexts.limited;
    case "incomplete":
    case "offline":
      return captureTexts.notFetched;
    default:
      return "";
  }
}
