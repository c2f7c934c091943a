import type { IconName } from "./icons.ts";

/** Display time (ms), and the number of letters for which this time is added again. */
const shownMs = 2500;
const lettersPerShownMs = 40;

/** More would cover the picture. */
const mostLetters = 500;

export interface ToastMessage {
  text: string;
  /** done: the visitor's action succeeded; note: information. */
  icon: IconName;
}

/** A short message that disappears by itself. */
export class Toast {
  readonly #changed: () => void;
  #message: ToastMessage | null = null;
  #timer = 0;

  constructor(changed: () => void) {
    this.#changed = changed;
  }

  get message(): ToastMessage | null {
    return this.#message;
  }

  /** Reports a completed action. */
  done(text: string): void {
    this.#show({ text, icon: "check" });
  }

  /** Reports an event that the visitor may not expect. It joins the notes that are still shown. */
  note(text: string): void {
    const { text: shown = "", icon } = this.#message ?? {};
    const isJoined = icon === "alert" && shown.length + text.length < mostLetters;
    if (icon === "alert" && shown.includes(text)) this.#show({ text: shown, icon });
    else this.#show({ text: isJoined ? `${shown} ${text}` : text, icon: "alert" });
  }

  /** Names something in the picture. */
  names(text: string): void {
    this.#show({ text, icon: "layers" });
  }

  #show(message: ToastMessage): void {
    this.#message = message;
    clearTimeout(this.#timer);
    const time = shownMs * (1 + Math.floor(message.text.length / lettersPerShownMs));
    this.#timer = window.setTimeout(() => {
      this.#message = null;
      this.#changed();
    }, time);
    this.#changed();
  }
}
