/** Replays visits through the proxy. Each viewer has a separate connection and address. */
import { type ClientHttp2Session, constants, type IncomingHttpHeaders } from "node:http2";
import { connectToProxy, type PackagedNginx } from "../../support/packaged_nginx.ts";
import type { Account } from "./account.ts";
import type { PlannedVisit, RecordedRequest } from "./requests.ts";

/** An address of this machine for each viewer, since the proxy limits rates by address. */
export function addressOf(viewer: number): string {
  return `127.${1 + (viewer >> 16)}.${(viewer >> 8) & 255}.${viewer & 255}`;
}

/** Waits until a moment of `performance.now()`. */
const until = (moment: number) =>
  new Promise((resolve) => setTimeout(resolve, Math.max(0, moment - performance.now())));

class Viewer {
  readonly #proxy: PackagedNginx;
  readonly #address: string;
  readonly #account: Account;
  #connection: Promise<ClientHttp2Session> | undefined;

  constructor(proxy: PackagedNginx, address: string, account: Account) {
    this.#proxy = proxy;
    this.#address = address;
    this.#account = account;
  }

  async visit({ visit }: PlannedVisit, begin: number): Promise<void> {
    const open: Promise<void>[] = [];
    for (const request of visit.requests) {
      await until(begin + request.at);
      open.push(this.#ask(request, begin + request.at));
    }
    await Promise.all(open);
    const connection = await this.#connection?.catch(() => undefined);
    connection?.close();
  }

  /**
   * The present connection, or a new one if the proxy has ended it, as it does after 1000 requests.
   */
  async #connected(): Promise<ClientHttp2Session> {
    const present = await this.#connection?.catch(() => undefined);
    if (present && !present.closed && !present.destroyed) return present;
    this.#connection = connectToProxy(this.#proxy, this.#address).then((connection) => {
      // A failed connection fails its requests.
      connection.on("error", () => {});
      return connection;
    });
    return this.#connection;
  }

  async #ask(request: RecordedRequest, due: number): Promise<void> {
    const { path, range, encoding, cancelledAfter } = request;
    let late = performance.now() - due;
    let headers: IncomingHttpHeaders = {};
    let bytes = 0;
    let isComplete = false;
    let isCancelled = false;
    let fault = "the answer is not complete";
    try {
      const connection = await this.#connected();
      late = performance.now() - due;
      const stream = connection.request({
        ":path": path,
        ...(range && { range }),
        ...(encoding && { "accept-encoding": encoding }),
      });
      const giveUp = () => {
        isCancelled = true;
        stream.close(constants.NGHTTP2_CANCEL);
      };
      const timer =
        cancelledAfter === undefined ? undefined : setTimeout(giveUp, cancelledAfter - late);
      await new Promise<void>((resolve) => {
        stream.on("response", (fields) => {
          headers = fields;
        });
        stream.on("data", (data: Buffer) => {
          bytes += data.length;
        });
        stream.on("end", () => {
          isComplete = true;
        });
        stream.on("error", (error) => {
          fault = error.message;
        });
        stream.on("close", resolve);
      });
      clearTimeout(timer);
    } catch (error) {
      fault = String(error);
    }
    const status = isComplete || isCancelled ? Number(headers[":status"]) || undefined : undefined;
    const cache = headers["x-cache"];
    this.#account.add({
      status,
      cache: typeof cache === "string" ? cache : undefined,
      bytes,
      latency: performance.now() - due,
      late,
      isCancelled: isCancelled && !isComplete,
      fault,
    });
  }
}

/** Replays visits at their times. Resolves when the last viewer has all answers. */
export async function replay(
  proxy: PackagedNginx,
  visits: readonly PlannedVisit[],
  account: Account,
): Promise<void> {
  const begin = performance.now();
  await Promise.all(
    visits.map(async (planned, i) => {
      await until(begin + planned.at);
      await new Viewer(proxy, addressOf(i), account).visit(planned, begin + planned.at);
    }),
  );
}
