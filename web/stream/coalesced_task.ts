/**
 * Does something soon, in a task of its own, and once for all that ask for it until then: so that
 * what comes together does not keep the main thread in one piece.
 */
export class CoalescedTask {
  readonly #work: () => void;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(work: () => void) {
    this.#work = work;
  }

  get isRequested(): boolean {
    return this.#timer !== undefined;
  }

  request(): void {
    this.#timer ??= setTimeout(() => {
      this.#timer = undefined;
      this.#work();
    }, 0);
  }

  cancel(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
  }
}
