import type { Progress } from "../stream/types.ts";
import type { FrameReport } from "../viewer/types.ts";
import { formatBytes, formatCount } from "./format.ts";
import { levelText, stateText } from "./status_text.ts";

const everyMs = 200;

/**
 * Shows what is drawn, its cost, and what is still to fetch. Only text, updated a few times a
 * second.
 */
export class StatusLine {
  readonly element = document.createElement("div");
  readonly #samples = this.#add("samples", "Samples drawn in the last frame");
  readonly #bytes = this.#add("bytes", "Payload fetched since the volume was opened");
  readonly #level = this.#add("level", "Level of detail shown; 0 is the volume itself");
  readonly #frames = this.#add("frames", "Frames per second while the view moves");
  readonly #state = this.#add("state", "What is left to fetch for this view");
  readonly #bar = document.createElement("div");
  #progress: Progress | null = null;
  #frame: FrameReport | null = null;
  #timer = 0;
  #maxToGo = 0;

  constructor() {
    this.element.className = "status";
    this.element.setAttribute("role", "group");
    this.element.setAttribute("aria-label", "Status");
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

  /** Called when the picture rests: hides the frame rate, which would be out of date. */
  rests(): void {
    if (this.#frame) this.frame({ ...this.#frame, framesPerSecond: 0 });
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
    set(this.#samples, frame ? `${formatCount(frame.samplesDrawn)} samples` : "");
    set(
      this.#frames,
      frame && frame.framesPerSecond > 0 ? `${Math.round(frame.framesPerSecond)} fps` : "",
    );
    set(this.#bytes, progress ? `${formatBytes(progress.bytesFetched)} fetched` : "");
    set(this.#level, progress ? levelText(progress) : "");
    set(this.#state, progress ? stateText(progress) : "");
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
