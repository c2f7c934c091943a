import { defaultSampleBudget } from "../stream/device.ts";

/** An element that needs a WebGL context while it is visible. */
export interface ContextUser {
  /** Whether some part of it is in the window. */
  readonly isVisible: boolean;
  /** Whether its picture will still change without further calls. */
  readonly isBusy: boolean;
  /** Whether it has the keyboard focus, and therefore keeps its context. */
  readonly isFocused: boolean;
  /** Grants it a context. It may hold this many samples (16 bytes each) on the GPU. */
  grant(sampleBudget: number): void;
  /** Sets its share of the samples, after the number of users has changed. */
  setSampleBudget(samples: number): void;
  /** Keeps a still picture and frees the context. */
  suspend(): Promise<void>;
}

/**
 * Decides which elements of a page have a WebGL context: browsers have few contexts (about 16 in a
 * process), and each takes memory on the GPU. An element without one shows its last picture. All
 * elements with a context share the sample budget in equal parts.
 *
 * If all contexts are in use, one is taken from an element that is out of sight; else from one
 * whose picture is finished; else, if the request is urgent, from any other; never from the one
 * with the focus. If there are several candidates, the least recently used one is chosen.
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

  /**
   * Requests a context, or reports the use of an existing one. isUrgent: a visitor is waiting for
   * it.
   */
  request(user: ContextUser, isUrgent = false): void {
    // A user that is being suspended waits for a new context.
    if (user !== this.#suspending && this.#holders.delete(user)) {
      this.#holders.add(user);
      return;
    }
    this.#waiting.add(user);
    if (isUrgent) this.#urgent.add(user);
    this.#assign();
  }

  /** The user needs no context any more. It must have freed its context, if it had one. */
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
