/** The requests that reach the server, by its counters. */
import { get } from "../../bench/server/hosts.ts";

export interface Served {
  requests: number;
  bytes: number;
}

interface Reading {
  /** In seconds. */
  at: number;
  routes: Map<string, Served>;
}

/** The shortest time over which a rate is computed (s). */
const shortest = 0.5;

/** Requests and bytes of bodies by route, from the text of `/metrics` (server/HTTP.md). */
export function servedByRoute(text: string): Map<string, Served> {
  const routes = new Map<string, Served>();
  const line =
    /^isosplat_http_(requests|response_body_bytes)_total\{route="([^"]*)"[^}]*\} (\d+)$/gm;
  for (const [, what, route = "", value] of text.matchAll(line)) {
    const served = routes.get(route) ?? { requests: 0, bytes: 0 };
    served[what === "requests" ? "requests" : "bytes"] += Number(value);
    routes.set(route, served);
  }
  return routes;
}

export function sum(routes: ReadonlyMap<string, Served>): Served {
  let [requests, bytes] = [0, 0];
  for (const served of routes.values()) {
    requests += served.requests;
    bytes += served.bytes;
  }
  return { requests, bytes };
}

/** Reads the server's counters each second. The readings themselves do not count. */
export class OriginMeter {
  readonly #url: string;
  readonly #readings: Reading[] = [];
  #timer: ReturnType<typeof setInterval> | undefined;

  private constructor(server: string) {
    this.#url = `${server.replace(/\/$/, "")}/metrics`;
  }

  static async start(server: string): Promise<OriginMeter> {
    const meter = new OriginMeter(server);
    await meter.#read();
    // A reading that fails is skipped, but the last one must not fail.
    meter.#timer = setInterval(() => void meter.#read().catch(() => {}), 1000);
    return meter;
  }

  async stop(): Promise<void> {
    clearInterval(this.#timer);
    await this.#read();
  }

  async #read(): Promise<void> {
    const { status, body } = await get(this.#url);
    if (status !== 200) throw new Error(`${this.#url}: expected 200, found ${status}`);
    const routes = servedByRoute(body.toString());
    routes.delete("/metrics");
    this.#readings.push({ at: performance.now() / 1000, routes });
  }

  /** From the start to the end, by route. */
  get byRoute(): Map<string, Served> {
    const [first, last] = [this.#readings[0], this.#readings.at(-1)];
    return new Map(
      [...(last?.routes ?? [])].map(([route, { requests, bytes }]) => {
        const before = first?.routes.get(route) ?? { requests: 0, bytes: 0 };
        return [route, { requests: requests - before.requests, bytes: bytes - before.bytes }];
      }),
    );
  }

  /** Between the first reading and the last (s). */
  get seconds(): number {
    return (this.#readings.at(-1)?.at ?? 0) - (this.#readings[0]?.at ?? 0);
  }

  /** Requests per second, between two readings. */
  get rates(): number[] {
    return this.#readings.flatMap(({ at, routes }, i) => {
      const before = this.#readings[i - 1];
      if (!before || at - before.at < shortest) return [];
      return [(sum(routes).requests - sum(before.routes).requests) / (at - before.at)];
    });
  }
}
