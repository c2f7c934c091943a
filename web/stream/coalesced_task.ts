/**
 * Runs work once, in a later task, for all requests made before it. So chunks that arrive together do
 * not block the main thread in one long task.
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
