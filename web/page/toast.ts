const shownMs = 2500;

/** A short message that goes away by itself. */
export class Toast {
  readonly #changed: () => void;
  #text = "";
  #timer = 0;

  constructor(changed: () => void) {
    this.#changed = changed;
  }

  /** Empty: there is none. */
  get text(): string {
    return this.#text;
  }

  say(text: string): void {
    this.#text = text;
    clearTimeout(this.#timer);
    this.#timer = window.setTimeout(() => {
      this.#text = "";
      this.#changed();
    }, shownMs);
    this.#changed();
  }
}
