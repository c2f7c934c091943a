/** Random faults for tests/browser/chaos.browser.ts; the same seed gives the same faults. */
import { Chance } from "../../support/chance.ts";
import type { Fault } from "../../support/fault_proxy.ts";

/**
 * Separate random numbers for each address and each of its requests. They do not depend on the
 * order in which requests for different addresses arrive.
 */
export class ChanceOfEach {
  readonly #seed: number;
  readonly #requests = new Map<string, number>();

  constructor(seed: number) {
    this.#seed = seed;
  }

  next(address: string): Chance {
    const number = this.#requests.get(address) ?? 0;
    this.#requests.set(address, number + 1);
    // FNV-1a.
    let hash = 0x811c9dc5;
    for (const letter of `${this.#seed} ${number} ${address}`) {
      hash = Math.imul(hash ^ (letter.codePointAt(0) ?? 0), 0x01000193);
    }
    return new Chance(hash);
  }
}

const statuses = [400, 401, 403, 404, 408, 410, 412, 416, 429, 500, 502, 503, 504];

/** A fault of a response. */
export function anyFault(chance: Chance): Fault {
  switch (chance.whole(0, 6)) {
    case 0:
      return { kind: "reset" };
    case 1:
      return { kind: "truncate", bytes: chance.whole(0, 60_000) };
    case 2:
      return { kind: "corrupt", at: chance.whole(0, 1 << 20) };
    case 3:
      return { kind: "drip", bytes: chance.whole(500, 5000) };
    case 4:
      return { kind: "elsewhere", path: "/v1/volumes/none" };
    case 5:
      return { kind: "status", status: chance.of(statuses) };
    default:
      // Responses arrive out of order.
      return { kind: "delay", milliseconds: chance.whole(0, 1500) };
  }
}
