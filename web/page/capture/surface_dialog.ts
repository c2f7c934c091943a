import "../shell/dialog_form.css";
import "../shell/components.ts";
import { html, nothing, render } from "lit";
import type { SurfaceForecast } from "../../mesh/forecast.ts";
import { forecastSurface, hasHoles, isClosed, saveSurface } from "../../mesh/save_surface.ts";
import { SurfaceReader } from "../../mesh/surface_reader.ts";
import { type MeshFormat, meshFormats } from "../../mesh/types.ts";
import { unitOf } from "../../overlay/length_unit.ts";
import type { StoreAccess } from "../../stream/session_parts.ts";
import { panelTexts } from "../../texts/panel.ts";
import { surfaceTexts } from "../../texts/surface.ts";
import { messageOf } from "../../texts/without_options.ts";
import type { Clip } from "../../viewer/types.ts";
import { formatBytes, formatCount, formatValue } from "../shell/format.ts";
import { askBeforeLeaving, keepOpen } from "../shell/keep_open.ts";

type Dialog = HTMLElement & { open: boolean };

export interface SurfaceDialogHost {
  /** Passes the file to the visitor. */
  save(ending: string, file: Blob): void;
  /** Asks for the distances between voxels, which the volume's file does not state. */
  enterSpacing?(): void;
}

interface SurfaceChange {
  format?: MeshFormat;
  level?: number;
  isClipped?: boolean;
  closed?: boolean;
}

/** Offers an isosurface of an open volume as a file of triangles. */
export function openSurfaceDialog(
  access: StoreAccess,
  isovalue: number,
  clip: Clip,
  host: SurfaceDialogHost,
): void {
  new SurfaceDialog(new SurfaceReader(access), isovalue, clip, host).open();
}

class SurfaceDialog {
  readonly #holder = document.createElement("div");
  readonly #reader: SurfaceReader;
  readonly #isovalue: number;
  readonly #clip: Clip;
  readonly #host: SurfaceDialogHost;
  #format: MeshFormat = "stl";
  #level = 0;
  #isClipped: boolean;
  /** Undefined: as the format is used. */
  #closing: boolean | undefined;
  #forecast: SurfaceForecast | undefined;
  /** Progress while the file is being created, 0 … 1. */
  #share: number | undefined;
  #message = "";
  /** Whether the last file could not be created because the surface cannot be closed. */
  #hasHoles = false;
  /** Aborts the forecast, or the creation of the file. */
  #work = new AbortController();
  /** Called when the dialog is closed, and the focus is where it was before. */
  #next: (() => void) | undefined;

  constructor(reader: SurfaceReader, isovalue: number, clip: Clip, host: SurfaceDialogHost) {
    this.#reader = reader;
    this.#isovalue = isovalue;
    this.#clip = clip;
    this.#host = host;
    this.#isClipped = this.#hasBox || this.#hasPlanes;
  }

  open(): void {
    document.body.append(this.#holder);
    this.#render();
    (this.#holder.firstElementChild as Dialog).open = true;
    void this.#foretell();
  }

  get #hasBox(): boolean {
    return this.#clip.low.some((n) => n > 0) || this.#clip.high.some((n) => n < 1);
  }

  get #hasPlanes(): boolean {
    return this.#clip.planes.length > 0;
  }

  get #isClosed(): boolean {
    return isClosed(this.#form);
  }

  /** Whether the planes of the clipping do not cut the surface that will be saved. */
  get #isUncut(): boolean {
    return this.#isClipped && this.#hasPlanes && !this.#isClosed;
  }

  /** Why the surface cannot be closed. */
  get #whyOpen(): string {
    return this.#level > 0 ? surfaceTexts.holesOfLevel : surfaceTexts.holesOfMissing;
  }

  /** What the visitor should know about closing the surface at this level. */
  get #closingNote(): string {
    if (this.#level === 0) return "";
    if (this.#isClosed) return surfaceTexts.mayNeedFull;
    const closesAtFull = isClosed({ ...this.#form, level: 0 });
    return closesAtFull ? surfaceTexts.openAtLevel : "";
  }

  get #form() {
    return {
      format: this.#format,
      level: this.#level,
      ...(this.#closing !== undefined && { closed: this.#closing }),
    };
  }

  get #options() {
    const { low, high, planes } = this.#clip;
    return {
      ...this.#form,
      ...(this.#isClipped && this.#hasBox && { box: { low, high } }),
      ...(this.#isClipped && this.#isClosed && { planes }),
    };
  }

  #begin(): AbortSignal {
    this.#work.abort(new DOMException("cancelled", "AbortError"));
    this.#work = new AbortController();
    return this.#work.signal;
  }

  async #foretell(): Promise<void> {
    const signal = this.#begin();
    this.#forecast = undefined;
    this.#message = "";
    this.#hasHoles = false;
    this.#render();
    try {
      const options = { ...this.#options, signal };
      const forecast = await forecastSurface(this.#reader, this.#isovalue, options);
      if (!signal.aborted) this.#forecast = forecast;
    } catch (error) {
      if (!signal.aborted) this.#message = messageOf(error);
    }
    this.#render();
  }

  async #make(): Promise<void> {
    const signal = this.#begin();
    this.#message = "";
    this.#hasHoles = false;
    this.#share = 0;
    this.#render();
    const stopAsking = askBeforeLeaving();
    try {
      const { file, triangles, closed } = await saveSurface(this.#reader, this.#isovalue, {
        ...this.#options,
        signal,
        progress: (share) => {
          this.#share = share;
          this.#render();
        },
      });
      if (triangles > 0) this.#host.save(this.#format, file);
      this.#message =
        triangles > 0
          ? surfaceTexts.saved(formatCount(triangles), formatBytes(file.size)) +
            (this.#isClosed && !closed ? ` ${surfaceTexts.leftOpen}` : "")
          : surfaceTexts.nothing;
    } catch (error) {
      this.#hasHoles = !signal.aborted && this.#isClosed && hasHoles(error);
      if (signal.aborted) this.#message = surfaceTexts.cancelled;
      else this.#message = this.#hasHoles ? this.#whyOpen : messageOf(error);
    }
    stopAsking();
    this.#share = undefined;
    this.#render();
  }

  /** Changes settings, and forecasts the new file. */
  #change(part: SurfaceChange): void {
    this.#closing = part.closed ?? this.#closing;
    this.#format = part.format ?? this.#format;
    this.#level = part.level ?? this.#level;
    this.#isClipped = part.isClipped ?? this.#isClipped;
    void this.#foretell();
  }

  get #status(): string {
    if (this.#message) return this.#message;
    const { problem, triangles, fileBytes, bytesToFetch, seconds } = this.#forecast ?? {};
    if (problem) return surfaceTexts.tooLarge(Math.round((triangles ?? 0) / 2e6));
    if (triangles === undefined || fileBytes === undefined || seconds === undefined) return "";
    const isCut = this.#isClipped && (this.#hasBox || this.#isClosed);
    const isLess = this.#level > 0 || isCut;
    const size = isLess ? surfaceTexts.atMost : surfaceTexts.about;
    const time = seconds < 1.5 ? surfaceTexts.aSecond : surfaceTexts.seconds(Math.round(seconds));
    const cost = surfaceTexts.cost(formatBytes(bytesToFetch ?? 0), time);
    return `${size(formatCount(triangles), formatBytes(fileBytes))} ${cost}`;
  }

  #render(): void {
    const { info } = this.#reader;
    const isRunning = this.#share !== undefined;
    const isReady = !isRunning && this.#forecast !== undefined && !this.#forecast.problem;
    const cells = (level: number) =>
      info.voxels.map((count) => Math.ceil((count - 1) / 2 ** level)).join(" × ");
    const chosen = (event: Event) => (event.currentTarget as HTMLSelectElement).value;
    render(
      html`<wa-dialog
        label=${surfaceTexts.title}
        @wa-hide=${(event: Event) => keepOpen(event, isRunning)}
        @wa-after-hide=${(event: Event) => this.#closed(event)}
      >
        <form
          class="dialog-form"
          @submit=${(event: Event) => {
            event.preventDefault();
            if (isReady) void this.#make();
          }}
        >
          <p>${surfaceTexts.lead(formatValue(this.#isovalue))}</p>
          <label>
            ${surfaceTexts.format}
            <select
              ?disabled=${isRunning}
              @change=${(event: Event) => this.#change({ format: chosen(event) as MeshFormat })}
            >
              ${meshFormats.map(
                (format) =>
                  html`<option value=${format} ?selected=${format === this.#format}>
                    ${surfaceTexts.formats[format]}
                  </option>`,
              )}
            </select>
          </label>
          <label>
            ${surfaceTexts.detail}
            <select
              ?disabled=${isRunning}
              @change=${(event: Event) => this.#change({ level: Number(chosen(event)) })}
            >
              ${Array.from(
                { length: info.levels },
                (_, level) =>
                  html`<option value=${level} ?selected=${level === this.#level}>
                    ${level === 0 ? surfaceTexts.full(cells(0)) : surfaceTexts.level(level, cells(level))}
                  </option>`,
              )}
            </select>
          </label>
          <label class="check">
            <input
              type="checkbox"
              ?disabled=${isRunning}
              .checked=${this.#isClosed}
              @change=${(event: Event) =>
                this.#change({ closed: (event.currentTarget as HTMLInputElement).checked })}
            />
            ${surfaceTexts.closed}
          </label>
          ${this.#closingNote ? html`<p class="quiet closing-note">${this.#closingNote}</p>` : nothing}
          ${
            this.#hasBox || this.#hasPlanes
              ? html`<label class="check">
                  <input
                    type="checkbox"
                    ?disabled=${isRunning}
                    .checked=${this.#isClipped}
                    @change=${(event: Event) =>
                      this.#change({
                        isClipped: (event.currentTarget as HTMLInputElement).checked,
                      })}
                  />
                  ${this.#isClosed ? surfaceTexts.clipped : surfaceTexts.wholeCells}
                </label>`
              : nothing
          }
          ${
            this.#hasPlanes
              ? html`<p class=${this.#isUncut ? "warning" : "visually-hidden"} role="status">
                  ${this.#isUncut ? surfaceTexts.planesNeedClosed : nothing}
                </p>`
              : nothing
          }
          ${this.#lengths()}
          ${
            isRunning
              ? html`<progress
                  aria-label=${surfaceTexts.saving}
                  max="1"
                  .value=${this.#share ?? 0}
                ></progress>`
              : html`<p role="status" class=${this.#message ? "" : "quiet"}>${this.#status}</p>`
          }
          ${this.#hasHoles ? this.#waysOn() : nothing}
          <div class="row">
            <wa-button type="submit" variant="brand" size="s" ?disabled=${!isReady}>${surfaceTexts.save}</wa-button>
            <wa-button
              class="cancel"
              size="s"
              appearance="outlined"
              ?disabled=${!isRunning}
              @click=${() => this.#work.abort(new DOMException("cancelled", "AbortError"))}
              >${surfaceTexts.cancel}</wa-button
            >
          </div>
        </form>
      </wa-dialog>`,
      this.#holder,
    );
  }

  /** The unit of the file's lengths. */
  #lengths() {
    const unit = unitOf(this.#reader.info);
    const text = surfaceTexts.lengths[unit][this.#format];
    const { enterSpacing } = this.#host;
    const isOffered = unit === "voxel" && enterSpacing !== undefined;
    const enter = () => {
      this.#next = enterSpacing;
      (this.#holder.firstElementChild as Dialog).open = false;
    };
    return html`<p class="quiet">${text}</p>
      ${
        isOffered
          ? html`<div><button
              class="chip"
              type="button"
              ?disabled=${this.#share !== undefined}
              @click=${enter}
            >
              ${panelTexts.enterSpacing}
            </button></div>`
          : nothing
      }`;
  }

  /** After a surface could not be closed. */
  #waysOn() {
    const way = (text: string, part: SurfaceChange) =>
      html`<button class="chip" type="button" @click=${() => this.#change(part)}>${text}</button>`;
    return html`<div class="chips">
      ${this.#level > 0 ? way(surfaceTexts.chooseFull, { level: 0, closed: true }) : nothing}
      ${way(surfaceTexts.leaveOpen, { closed: false })}
    </div>`;
  }

  #closed(event: Event): void {
    if (event.target === this.#holder.firstElementChild) this.#end();
  }

  #end(): void {
    this.#work.abort(new DOMException("the dialog was closed", "AbortError"));
    this.#holder.remove();
    this.#next?.();
  }
}
