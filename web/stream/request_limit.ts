/** One user of a RequestLimit. */
export interface RequestShare {
  /** The number of further requests that may begin now. */
  readonly free: number;
  /** The user has further requests: `freed` is called once when others leave room. */
  wait(): void;
  begin(): void;
  ended(): void;
  /** The user ends, and with it its requests. */
  leave(): void;
}

interface Member {
  concurrency: () => number;
  freed: () => void;
  running: number;
}

/**
 * Limits the requests that several sessions make at a time to those that the most capable of their sources
 * makes alone. A request that ends makes room for another session first, so that all get their turn.
 */
export class RequestLimit {
  readonly #members = new Set<Member>();
  /** In the order in which they began to wait. */
  readonly #waiting = new Set<Member>();
  #running = 0;
  /** The largest concurrency of the members. Undefined: to be found. */
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
      leave: () => {
        if (!this.#members.delete(member)) return;
        this.#waiting.delete(member);
        this.#run(member, -member.running);
        this.#release(member);
      },
    };
  }

  get #free(): number {
    this.#largest ??= Math.max(...[...this.#members].map(({ concurrency }) => concurrency()));
    return this.#largest - this.#running;
  }

  #run(member: Member, change: number): void {
    member.running += change;
    this.#running += change;
  }

  #release(member: Member): void {
    this.#largest = undefined;
    const others = [...this.#waiting].filter((other) => other !== member);
    for (const other of others) this.#waiting.delete(other);
    for (const other of others) other.freed();
  }
}
