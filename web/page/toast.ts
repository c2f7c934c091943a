import type { IconName } from "./icons.ts";

/** Long enough to read: this, and as long again for each so many letters. */
const shownMs = 2500;
const lettersPerShown = 40;

export interface ToastMessage {
  text: string;
  /** done: what the visitor asked for; note: something to know. */
  icon: IconName;
}

/** A short message that goes away by itself. */
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

  /** Something was done. */
  done(text: string): void {
    this.#show({ text, icon: "check" });
  }

  /** Something is otherwise than the visitor may think. */
  note(text: string): void {
    this.#show({ text, icon: "alert" });
  }

  #show(message: ToastMessage): void {
    this.#message = message;
    clearTimeout(this.#timer);
    const time = shownMs * (1 + Math.floor(message.text.length / lettersPerShown));
    this.#timer = window.setTimeout(() => {
      this.#message = null;
      this.#changed();
    }, time);
    this.#changed();
  }
}
