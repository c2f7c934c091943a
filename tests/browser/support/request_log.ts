import type { CDPSession, Page } from "@playwright/test";

interface Request {
  /** Method, address, and range. */
  what: string;
  /** When the browser sent it (ms). */
  at: number;
}

/** What a page asks for, by the browser's own clock; what never arrives is there, too. */
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

  /** What was asked for again less than so long (ms) after the time before, with how long. */
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

  /** The browser forgets what it has fetched. */
  async clearCaches(): Promise<void> {
    await this.#session.send("Network.clearBrowserCache");
  }
}
