/** One user of a RequestLimit. */
export interface RequestShare {
  /** The number of further requests that may begin now. */
  readonly free: number;
  begin(): void;
  ended(): void;
  /** The user ends, and with it its requests. */
  leave(): void;
}

interface Member {
  concurrency: () => number;
  /** Requests may begin. */
  freed: () => void;
  running: number;
}

/**
 * Limits the requests that several sessions make at a time to those that the most capable of their sources
 * makes alone. A request that ends makes room for another session first, so that all get their turn.
 */
export class RequestLimit {
  #members: Member[] = [];

  /** `concurrency`: of the source. `freed` is called when a request of another session has ended. */
  join(concurrency: () => number, freed: () => void): RequestShare {
    const member: Member = { concurrency, freed, running: 0 };
    this.#members.push(member);
    const limit = this;
    return {
      get free() {
        return Math.min(concurrency() - member.running, limit.#free);
      },
      begin: () => void ++member.running,
      ended: () => {
        if (!this.#members.includes(member)) return;
        --member.running;
        this.#members = [...this.#others(member), member];
        this.#tell(member);
      },
      leave: () => {
        this.#members = this.#others(member);
        this.#tell(member);
      },
    };
  }

  get #free(): number {
    const limit = Math.max(...this.#members.map(({ concurrency }) => concurrency()));
    return limit - this.#members.reduce((sum, { running }) => sum + running, 0);
  }

  #others(member: Member): Member[] {
    return this.#members.filter((other) => other !== member);
  }

  #tell(member: Member): void {
    for (const other of this.#others(member)) other.freed();
  }
}
