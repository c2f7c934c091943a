/** The share of one session in a RequestLimit. */
export interface RequestShare {
  /** The number of further requests that may begin now. */
  readonly free: number;
  /** Call it if the session has further requests. `freed` is called once when other requests have ended. */
  wait(): void;
  begin(): void;
  ended(): void;
  /** Until `resume`, no session begins requests. */
  pause(): void;
  resume(): void;
  /** Call it when the session ends. Its requests no longer count. */
  leave(): void;
}

interface Member {
  concurrency: () => number;
  freed: () => void;
  running: number;
}

/**
 * Limits the simultaneous requests of several sessions to the largest `concurrency` of their sources. When a
 * request ends, another session has the next turn. A session can pause the requests of all, so that what it has
 * received is in the picture before others receive more.
 */
export class RequestLimit {
  readonly #members = new Set<Member>();
  /** The waiting sessions, in the order in which they began to wait. */
  readonly #waiting = new Set<Member>();
  readonly #pausing = new Set<Member>();
  #running = 0;
  /** The largest concurrency of the members. Undefined until it is computed again. */
  #largest: number | undefined;

  /** `concurrency`: of the source; it may change when a request ends. `freed`: see RequestShare.wait. */
  join(concurrency: () => number, freed: () => void): RequestShare {
    const member: Member = { concurrency, freed, running: 0 };
    this.#members.add(member);
    this.#largest = undefined;
    const limit = this;
    return {
      get free() {
        return Math.min(concurrency() - member.running, limit.#free);
      },
      wait: () => void this.#waiting.add(member),
      begin: () => this.#run(member, 1),
      ended: () => {
        if (!this.#members.has(member)) return;
        this.#run(member, -1);
        this.#release(member);
      },
      pause: () => void (this.#members.has(member) && this.#pausing.add(member)),
      resume: () => {
        if (this.#pausing.delete(member) && this.#pausing.size === 0) this.#release();
      },
      leave: () => {
        if (!this.#members.delete(member)) return;
        this.#waiting.delete(member);
        this.#pausing.delete(member);
        this.#run(member, -member.running);
        this.#release(member);
      },
    };
  }

  get #free(): number {
    if (this.#pausing.size > 0) return 0;
    this.#largest ??= Math.max(...[...this.#members].map(({ concurrency }) => concurrency()));
    return this.#largest - this.#running;
  }

  #run(member: Member, change: number): void {
    member.running += change;
    this.#running += change;
  }

  /** Gives the waiting sessions their turn, except the one whose request has ended. */
  #release(member?: Member): void {
    this.#largest = undefined;
    if (this.#pausing.size > 0) return;
    const others = [...this.#waiting].filter((other) => other !== member);
    for (const other of others) this.#waiting.delete(other);
    for (const other of others) other.freed();
  }
}
