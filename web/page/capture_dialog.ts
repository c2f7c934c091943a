import "./capture.css";
import { html, nothing, render } from "lit";
import { type CaptureProgress, capturePng, mostPixels } from "../capture/picture.ts";
import type { PictureSize, Viewer } from "../viewer/index.ts";
import { formatBytes } from "./format.ts";

type Dialog = HTMLElement & { open: boolean };

export interface CaptureHost {
  viewer: Viewer;
  /** Saves a file whose name begins with that of the volume. */
  save(ending: string, content: Blob): void;
}

interface SizeChoice {
  name: string;
  label: string;
  size: PictureSize;
}

/** The dialog that saves pictures of any size. */
export class CaptureDialog {
  readonly #host: CaptureHost;
  readonly #holder = document.createElement("div");
  #sizeName = "shown";
  #own: PictureSize = { width: 4096, height: 4096 };
  #transparent = false;
  #running: AbortController | null = null;
  #progress: CaptureProgress = {};
  #message = "";

  constructor(host: CaptureHost) {
    this.#host = host;
  }

  async open(): Promise<void> {
    await import("./components.ts");
    document.body.append(this.#holder);
    this.#message = "";
    this.#render();
    (this.#holder.firstElementChild as Dialog).open = true;
  }

  get #sizes(): SizeChoice[] {
    const { width, height } = this.#host.viewer.canvas;
    const times = (factor: number): SizeChoice => ({
      name: factor === 1 ? "shown" : `${factor}×`,
      label: factor === 1 ? "As shown" : `${factor} × as shown`,
      size: { width: factor * width, height: factor * height },
    });
    const fixed = (name: string, width: number, height: number): SizeChoice => ({
      name,
      label: name,
      size: { width, height },
    });
    const all = [
      times(1),
      times(2),
      times(4),
      fixed("Full HD", 1920, 1080),
      fixed("4K", 3840, 2160),
      fixed("8K", 7680, 4320),
    ];
    return all.filter(({ size }) => Math.max(size.width, size.height) <= mostPixels);
  }

  get #size(): PictureSize {
    return this.#sizes.find(({ name }) => name === this.#sizeName)?.size ?? this.#own;
  }

  /** Why the size cannot be used; undefined: it can. */
  get #sizeProblem(): string | undefined {
    const { width, height } = this.#size;
    const isFine = (px: number) => Number.isInteger(px) && px >= 1 && px <= mostPixels;
    if (isFine(width) && isFine(height)) return undefined;
    return `Width and height: whole numbers from 1 to ${mostPixels}.`;
  }

  #render(): void {
    const isRunning = this.#running !== null;
    const problem = this.#sizeProblem;
    render(
      html`<wa-dialog
        label="Save a picture of any size"
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
            <label>
              Size in pixels
              <select
                @change=${(event: Event) => {
                  this.#sizeName = (event.currentTarget as HTMLSelectElement).value;
                  this.#render();
                }}
              >
                ${this.#sizes.map(
                  ({ name, label, size }) =>
                    html`<option value=${name} ?selected=${name === this.#sizeName}>
                      ${label}: ${size.width} × ${size.height}
                    </option>`,
                )}
                <option value="own" ?selected=${this.#sizeName === "own"}>Other …</option>
              </select>
            </label>
            ${
              this.#sizeName === "own"
                ? html`<div class="row">
                    ${this.#ownPixels("width", "Width")} ${this.#ownPixels("height", "Height")}
                  </div>`
                : nothing
            }
            <label class="check">
              <input
                type="checkbox"
                .checked=${this.#transparent}
                @change=${(event: Event) => {
                  this.#transparent = (event.currentTarget as HTMLInputElement).checked;
                }}
              />
              Without background (transparent)
            </label>
          </fieldset>
          ${isRunning ? this.#progressPart() : nothing}
          <p role="status" class=${problem ? "" : "quiet"}>
            ${problem ?? (isRunning ? this.#progressText : this.#message)}
          </p>
          <div class="capture-actions">
            ${
              isRunning
                ? html`<wa-button size="s" appearance="outlined" @click=${() => this.#running?.abort()}
                    >Cancel</wa-button
                  >`
                : html`<wa-button
                    type="submit"
                    variant="brand"
                    size="s"
                    ?disabled=${problem !== undefined}
                    >Save</wa-button
                  >`
            }
          </div>
        </form>
      </wa-dialog>`,
      this.#holder,
    );
  }

  #ownPixels(side: "width" | "height", label: string) {
    return html`<label>
      ${label}
      <input
        type="number"
        min="1"
        max=${mostPixels}
        inputmode="numeric"
        .value=${String(this.#own[side])}
        @input=${(event: Event) => {
          const value = (event.currentTarget as HTMLInputElement).valueAsNumber;
          this.#own = { ...this.#own, [side]: value };
          this.#render();
        }}
      />
    </label>`;
  }

  #progressPart() {
    const { share } = this.#progress;
    return share === undefined
      ? html`<progress aria-label="Saving"></progress>`
      : html`<progress aria-label="Saving" max="1" .value=${share}></progress>`;
  }

  get #progressText(): string {
    const { share, bytesToGo } = this.#progress;
    if (share !== undefined) return `Drawing: ${Math.round(100 * share)} %`;
    return bytesToGo ? `Fetching: ${formatBytes(bytesToGo)} to go` : "Preparing";
  }

  async #run(): Promise<void> {
    const { viewer, save } = this.#host;
    const running = new AbortController();
    this.#running = running;
    this.#progress = {};
    this.#render();
    const { width, height } = this.#size;
    const progress = (now: CaptureProgress): void => {
      this.#progress = now;
      this.#render();
    };
    try {
      const options = { transparent: this.#transparent, signal: running.signal, progress };
      const picture = await capturePng(viewer, { width, height }, options);
      save(`${width}x${height}.png`, picture);
      this.#message = `Saved: ${formatBytes(picture.size)}. ${shortcoming(viewer)}`;
    } catch (error) {
      if (running.signal.aborted) this.#message = "Cancelled";
      else this.#message = error instanceof Error ? error.message : String(error);
    }
    this.#running = null;
    this.#render();
  }
}

/** What the picture lacks, in a sentence; empty if it lacks nothing. */
function shortcoming(viewer: Viewer): string {
  switch (viewer.progress?.state) {
    case "limited":
      return "Parts are coarser than this size could show: the limit of memory was reached.";
    case "incomplete":
    case "offline":
      return "Parts are coarser than this size could show: their data could not be fetched.";
    default:
      return "";
  }
}
