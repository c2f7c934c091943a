import type { CDPSession, Page } from "@playwright/test";

interface Request {
  /** Method, address, and range. */
  what: string;
  /** Time at which the browser sent it (ms). */
  at: number;
}

/** A page's requests with the browser's own times, including requests that never reach a server. */
export class RequestLog {
  readonly #session: CDPSession;
  #requests: Request[] = [];

  private constructor(session: CDPSession) {
    this.#session = session;
  }

  static async of(page: Page): Promise<RequestLog> {
    const session = await page.context().newCDPSession(page);
    const log = new RequestLog(session);
    session.on("Network.requestWillBeSent", ({ request, wallTime }) => {
      if (!request.url.startsWith("http")) return;
      const range = request.headers.Range ?? request.headers.range ?? "";
      const what = `${request.method} ${request.url} ${range}`.trim();
      log.#requests.push({ what, at: 1000 * wallTime });
    });
    await session.send("Network.enable");
    return log;
  }

  get size(): number {
    return this.#requests.length;
  }

  clear(): void {
    this.#requests = [];
  }

  /** Requests that were repeated after less than this time (ms), with the interval. */
  closerThan(milliseconds: number): string[] {
    const last = new Map<string, number>();
    const close: string[] = [];
    for (const { what, at } of this.#requests) {
      const gap = at - (last.get(what) ?? Number.NEGATIVE_INFINITY);
      if (gap < milliseconds) close.push(`${what}: after ${Math.round(gap)} ms`);
      last.set(what, at);
    }
    return close;
  }

  /** Clears the browser's cache. */
  async clearCaches(): Promise<void> {
    await this.#session.send("Network.clearBrowserCache");
  }
}
