import { defaultSampleBudget } from "../stream/device.ts";

/** An element that needs a WebGL context while it can be seen. */
export interface ContextUser {
  /** Some part of it is in the window. */
  readonly isVisible: boolean;
  /** Its picture will still change without further calls. */
  readonly isBusy: boolean;
  /** The keyboard is in it: it keeps its context. */
  readonly isFocused: boolean;
  /** It has a context now, and may hold this many samples (16 bytes each) on the GPU. */
  grant(sampleBudget: number): void;
  /** The number of users has changed, and with it the share of each. */
  setSampleBudget(samples: number): void;
  /** Keeps a still picture and frees the context. */
  suspend(): Promise<void>;
}

/**
 * Decides which elements of a page have a WebGL context: browsers have few of them (about 16 in a
 * process), and each has memory on the GPU. An element that has none shows its last picture. The
 * sample budget is shared: each holder has an equal part.
 *
 * If all contexts are in use, one is taken from a holder that is out of sight; else from one whose
 * picture is finished; else, if the request is urgent, from any other; never from the one that has
 * the focus. Of several it is the one whose last use is the longest ago.
 */
export class ContextPool {
  readonly #limit: number;
  readonly #budget: () => number;
  /** In the order of their last use. */
  readonly #holders = new Set<ContextUser>();
  readonly #waiting = new Set<ContextUser>();
  readonly #urgent = new Set<ContextUser>();
  #suspending: ContextUser | null = null;

  /** budget: the samples of all holders together. */
  constructor(limit: number, budget: () => number = defaultSampleBudget) {
    this.#limit = limit;
    this.#budget = budget;
  }

  /** The user wants a context, or uses the one that it has. isUrgent: a visitor is waiting for it. */
  request(user: ContextUser, isUrgent = false): void {
    // One that is being suspended waits for a new context.
    if (user !== this.#suspending && this.#holders.delete(user)) {
      this.#holders.add(user);
      return;
    }
    this.#waiting.add(user);
    if (isUrgent) this.#urgent.add(user);
    this.#assign();
  }

  /** The user wants no context any more. It has freed its own, if it had one. */
  release(user: ContextUser): void {
    this.#waiting.delete(user);
    this.#urgent.delete(user);
    if (this.#holders.delete(user)) this.#share();
    this.#assign();
  }

  /** `isVisible` or `isBusy` of a user has changed. */
  changed(): void {
    this.#assign();
  }

  #assign(): void {
    const [next] = this.#urgent.size > 0 ? this.#urgent : this.#waiting;
    if (!next || this.#suspending) return;
    if (this.#holders.size < this.#limit) {
      this.#waiting.delete(next);
      this.#urgent.delete(next);
      this.#holders.add(next);
      this.#share(next);
      next.grant(this.#part());
      this.#assign();
      return;
    }
    const victim = this.#victim(this.#urgent.has(next));
    if (!victim) return;
    this.#suspending = victim;
    void victim.suspend().finally(() => {
      this.#suspending = null;
      if (this.#holders.delete(victim)) this.#share();
      this.#assign();
    });
  }

  #victim(isUrgent: boolean): ContextUser | undefined {
    const holders = [...this.#holders].filter((user) => !user.isFocused);
    return (
      holders.find((user) => !user.isVisible) ??
      holders.find((user) => !user.isBusy) ??
      (isUrgent ? holders[0] : undefined)
    );
  }

  #part(): number {
    return Math.floor(this.#budget() / Math.max(1, this.#holders.size));
  }

  #share(except?: ContextUser): void {
    for (const user of this.#holders) if (user !== except) user.setSampleBudget(this.#part());
  }
}
