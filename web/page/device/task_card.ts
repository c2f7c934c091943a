import { html, nothing, render } from "lit";
import type { BuildProgress } from "../../builder/types.ts";
import { CoreError } from "../../core/calls.ts";
import { deviceTexts } from "../../texts/device.ts";
import { deviceErrorTexts } from "../../texts/device_errors.ts";
import { pageTexts } from "../../texts/page.ts";
import { messageOf } from "../../texts/without_options.ts";
import { formatBytes, formatDuration } from "../shell/format.ts";

/** A task for files of this device: a card with its progress, and a button that cancels it. */
export class Task {
  readonly #card = document.createElement("section");
  readonly #cancel = new AbortController();
  #title: string;
  #text = "";
  #fraction: number | undefined;
  #remark = "";
  #error: string | undefined;
  #cause = "";
  isRunning = true;

  constructor(title: string) {
    this.#title = title;
    this.#card.className = "task-card";
    this.#card.setAttribute("aria-label", deviceTexts.title);
  }

  /** Aborted when the visitor cancels. */
  get signal(): AbortSignal {
    return this.#cancel.signal;
  }

  shows(title: string, text: string): void {
    this.#title = title;
    this.#text = text;
    this.#fraction = undefined;
    this.#render();
  }

  progress({ fraction, secondsLeft }: BuildProgress, bytes: number): void {
    this.#fraction = fraction;
    const left = secondsLeft > 0 ? ` · ${pageTexts.left(formatDuration(secondsLeft))}` : "";
    this.#text = deviceTexts.of(formatBytes(fraction * bytes), formatBytes(bytes)) + left;
    this.#render();
  }

  /** `bytes`: size of the whole file, if it is known. */
  fetching(title: string, received: number, bytes: number | undefined): void {
    this.#title = title;
    this.#fraction = bytes ? received / bytes : undefined;
    this.#text = bytes
      ? deviceTexts.of(formatBytes(received), formatBytes(bytes))
      : formatBytes(received);
    this.#render();
  }

  /** Adds a sentence while the task runs. */
  remarks(text: string): void {
    this.#remark = text;
    this.#render();
  }

  /** Shows an error until the visitor closes it. */
  failed(error: unknown): void {
    this.fail(messageOf(error), deviceTexts.notOpened, causeOf(error));
  }

  /**
   * Shows the message until the visitor closes it. `cause`: a sentence before a message that is in English
   * in every language.
   */
  fail(message: string, title = deviceTexts.notOpened, cause = ""): void {
    this.isRunning = false;
    this.#cause = cause;
    this.#title = title;
    this.#error = message;
    this.#render();
  }

  close(): void {
    this.isRunning = false;
    this.#card.remove();
  }

  #render(): void {
    if (!this.#card.isConnected) document.body.append(this.#card);
    const isFailed = this.#error !== undefined;
    render(
      html`<div class="task-text" role=${isFailed ? "alert" : "status"}>
          <strong>${this.#title}</strong>
          ${isFailed && this.#cause ? html`<span>${this.#cause}</span>` : nothing}
          <span class=${isFailed && !this.#cause ? "" : "quiet"}>${this.#error ?? this.#text}</span>
          ${isFailed || !this.#remark ? nothing : html`<span>${this.#remark}</span>`}
        </div>
        ${
          isFailed
            ? nothing
            : html`<progress aria-label=${this.#title} .value=${this.#fraction ?? 0} max="1"></progress>`
        }
        <button
          type="button"
          class="chip"
          @click=${() => (isFailed ? this.close() : this.#stop())}
        >
          ${isFailed ? deviceTexts.close : deviceTexts.cancel}
        </button>`,
      this.#card,
    );
  }

  #stop(): void {
    this.#cancel.abort(new DOMException("cancelled", "AbortError"));
  }
}

/** The cause of an error of the core, in the page's language. */
function causeOf(error: unknown): string {
  const causes: Readonly<Record<string, string>> = deviceErrorTexts.causes;
  return error instanceof CoreError ? (causes[error.status] ?? "") : "";
}
