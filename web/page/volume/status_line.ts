import type { Progress } from "../../stream/types.ts";
import { pageTexts } from "../../texts/page.ts";
import { isWhole } from "../../viewer/clipping.ts";
import type { FrameReport } from "../../viewer/types.ts";
import type { Viewer } from "../../viewer/viewer.ts";
import { formatBytes, formatCount } from "../shell/format.ts";
import { levelText, stateText } from "./status_text.ts";

const everyMs = 200;

/**
 * Shows the drawn levels, their cost, and the data still to fetch. Contains only text, which is updated
 * a few times a second.
 */
export class StatusLine {
  readonly element = document.createElement("div");
  readonly #samples = this.#add("samples", pageTexts.samplesTitle);
  readonly #bytes = this.#add("bytes", pageTexts.bytesTitle);
  readonly #level = this.#add("level", pageTexts.levelTitle);
  readonly #frames = this.#add("frames", pageTexts.framesTitle);
  readonly #state = this.#add("state", pageTexts.stateTitle);
  readonly #quick = this.#add("quick", pageTexts.quickTitle);
  readonly #bar = document.createElement("div");
  #progress: Progress | null = null;
  #frame: FrameReport | null = null;
  #timer = 0;
  #maxToGo = 0;

  readonly #viewer: Pick<Viewer, "clip" | "isQuick">;

  constructor(viewer: Pick<Viewer, "clip" | "isQuick">) {
    this.#viewer = viewer;
    this.element.className = "status";
    this.element.setAttribute("role", "group");
    this.element.setAttribute("aria-label", pageTexts.status);
    this.#state.setAttribute("role", "status");
    this.#bar.className = "progress";
    this.element.append(this.#bar);
  }

  progress(progress: Progress): void {
    this.#progress = progress;
    this.#schedule();
  }

  frame(frame: FrameReport): void {
    this.#frame = frame;
    this.#schedule();
  }

  /** Called when the picture rests: hides the frame rate, which would be outdated. */
  rests(): void {
    if (this.#frame) this.frame({ ...this.#frame, framesPerSecond: 0 });
    this.#schedule();
  }

  clear(): void {
    this.#progress = null;
    this.#frame = null;
    this.#schedule();
  }

  #add(name: string, title: string): HTMLElement {
    const span = document.createElement("span");
    span.className = `status-${name}`;
    span.title = title;
    this.element.append(span);
    return span;
  }

  #schedule(): void {
    if (this.#timer === 0) {
      this.#timer = window.setTimeout(() => {
        this.#timer = 0;
        this.#write();
      }, everyMs);
    }
  }

  #write(): void {
    const progress = this.#progress;
    const frame = this.#frame;
    set(this.#samples, frame ? pageTexts.samples(formatCount(frame.samplesDrawn)) : "");
    set(
      this.#frames,
      frame && frame.framesPerSecond > 0 ? pageTexts.frames(Math.round(frame.framesPerSecond)) : "",
    );
    set(this.#bytes, progress ? pageTexts.fetched(formatBytes(progress.bytesFetched)) : "");
    set(this.#level, progress ? levelText(progress) : "");
    set(this.#state, progress ? stateText(progress, !isWhole(this.#viewer.clip)) : "");
    const isQuick = progress?.state === "complete" && this.#viewer.isQuick;
    set(this.#quick, isQuick ? pageTexts.quick : "");
    this.element.dataset.state = progress?.state ?? "none";

    const toGo = progress?.bytesToGo ?? 0;
    this.#maxToGo = toGo === 0 ? 0 : Math.max(this.#maxToGo, toGo);
    const done = this.#maxToGo === 0 ? 1 : 1 - toGo / this.#maxToGo;
    this.#bar.style.setProperty("--done", String(done));
  }
}

/** Sets the text only if it changes: screen readers announce every assignment. */
function set(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}
