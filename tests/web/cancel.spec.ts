// Requests that are no longer needed are cancelled, for the client and for the server.
import { createServer, type Server, type ServerResponse } from "node:http";
import type { AddressInfo } from "node:net";
import { afterEach, beforeAll, beforeEach, expect, it } from "vitest";
import type { Chunk, Core } from "../../web/core/index.ts";
import { Backoff } from "../../web/stream/backoff.ts";
import { ChunkQueue } from "../../web/stream/chunk_queue.ts";
import { InlineDecoder } from "../../web/stream/decoder.ts";
import type { ChunkPlaceInFile, Source } from "../../web/stream/source.ts";
import { Traffic, transfer } from "../../web/stream/transfer.ts";
import { core as load, openWhole, storeBytes } from "./fixture.ts";

/** A host whose responses begin and never end. */
let host: Server;
let url: string;
let answering: Promise<{ response: ServerResponse; closed: Promise<void> }>;

beforeEach(async () => {
  host = createServer();
  answering = new Promise((resolve) => {
    host.once("request", (_request, response) => {
      const closed = new Promise<void>((ended) => response.once("close", ended));
      response.writeHead(200, { "Content-Length": 1_000_000 });
      response.write(new Uint8Array(1000));
      resolve({ response, closed });
    });
  });
  await new Promise<void>((resolve) => host.listen(0, "127.0.0.1", resolve));
  url = `http://127.0.0.1:${(host.address() as AddressInfo).port}/`;
});
afterEach(async () => {
  host.closeAllConnections();
  await new Promise((resolve) => host.close(resolve));
});

it("an aborted transfer rejects with the reason, and closes its connection", async () => {
  const ending = new AbortController();
  const traffic = new Traffic();
  const reason = new Error("enough");
  let parts = 0;
  let begun = () => {};
  const firstPart = new Promise<void>((resolve) => {
    begun = resolve;
  });
  const transferring = transfer(url, {}, traffic, ending.signal, () => {
    ++parts;
    begun();
  });
  await firstPart;
  const { closed, response } = await answering;
  expect(response.writableEnded).toBe(false);
  ending.abort(reason);
  await expect(transferring).rejects.toBe(reason);
  await closed; // the host notices it while it still has data to send
  expect(traffic.bytesReceived).toBe(1000);
  expect(parts).toBe(1);
});

it("a transfer that is aborted before it begins makes no request", async () => {
  const traffic = new Traffic();
  const aborted = AbortSignal.abort(new Error("too late"));
  await expect(transfer(url, {}, traffic, aborted, () => {})).rejects.toThrow("too late");
  expect(traffic.requests).toBe(0);
});

/** A source with requests that the test answers or leaves pending. */
class HeldSource implements Source {
  readonly name = "held";
  readonly concurrency = 2;
  readonly requests = 0;
  readonly bytesReceived = 0;
  readonly calls: {
    handles: number[];
    signal: AbortSignal;
    give: (index: number) => void;
    end: () => void;
  }[] = [];
  readonly #file: Uint8Array;

  constructor(file: Uint8Array) {
    this.#file = file;
  }

  chunks<C extends ChunkPlaceInFile>(
    chunks: readonly C[],
    signal: AbortSignal,
    arrived: (chunk: C, bytes: Uint8Array) => void,
  ): Promise<void> {
    return new Promise((resolve, reject) => {
      signal.addEventListener("abort", () => reject(signal.reason));
      this.calls.push({
        handles: chunks.map((chunk) => (chunk as unknown as Chunk).handle),
        signal,
        give: (index) => {
          const chunk = chunks[index];
          if (!chunk) throw new Error("no such chunk");
          arrived(chunk, this.#file.slice(chunk.offset, chunk.offset + chunk.bytes));
        },
        end: resolve,
      });
    });
  }

  group<C extends ChunkPlaceInFile>(chunks: readonly C[]): C[][] {
    return [chunks.slice(0, 2), chunks.slice(2)].filter((group) => group.length > 0);
  }

  readonly fileBytes = undefined;
  readonly fresh = false;
  warm(): void {}
  bypassCaches(): void {}
  forget(): void {}
  contentId(): Promise<string> {
    throw new Error("not used by this test");
  }
  header(): Promise<Uint8Array> {
    throw new Error("not used by this test");
  }
  range(): Promise<void> {
    throw new Error("not used by this test");
  }
  pages(): Promise<void> {
    throw new Error("not used by this test");
  }
}

let core: Core;
let file: Uint8Array;
let chunks: Chunk[];
beforeAll(async () => {
  core = await load();
  file = storeBytes();
  chunks = openWhole(core, file).chunksFor(0, 100, 100).slice(0, 4);
});

/** The requests of the queue to its source, and its events. */
function queueOf(source: HeldSource) {
  const released: number[] = [];
  const decoded: number[] = [];
  const errors: unknown[] = [];
  let wake = () => {};
  const queue = new ChunkQueue(
    source,
    new InlineDecoder(core),
    new Backoff({ trouble: () => {} }),
    {
      admit: () => true,
      decoded: (chunk) => {
        decoded.push(chunk.handle);
        wake();
      },
      released: (chunk) => {
        released.push(chunk.handle);
        wake();
      },
      failed: (error) => errors.push(error),
      changed: () => wake(),
    },
  );
  /** Waits until a condition holds. Checks it whenever the queue reports a change. */
  const until = async (what: () => boolean): Promise<void> => {
    while (!what()) {
      await new Promise<void>((resolve) => {
        wake = resolve;
      });
    }
  };
  return { queue, released, decoded, errors, until };
}

it("only a request of which no chunk is needed any more is aborted", async () => {
  const source = new HeldSource(file);
  const { queue, released, errors, until } = queueOf(source);
  queue.need(chunks);
  await until(() => source.calls.length === 2);
  const [first, second] = source.calls;
  const [a, b, c, d] = chunks.map((chunk) => chunk.handle);
  expect([first?.handles, second?.handles]).toEqual([
    [a, b],
    [c, d],
  ]);

  queue.need(chunks.slice(1, 2)); // one chunk of the first request
  expect(first?.signal.aborted).toBe(false);
  expect(second?.signal.aborted).toBe(true);
  expect(second?.signal.reason).toMatchObject({ name: "AbortError" });
  await until(() => released.length === 2);
  expect(released).toEqual([c, d]);
  expect(queue.state(c as number)).toBeUndefined();

  queue.need([]);
  expect(first?.signal.aborted).toBe(true);
  await until(() => queue.idle);
  expect(errors).toEqual([]);
});

it("a chunk that is needed again after it was cancelled is requested again", async () => {
  const source = new HeldSource(file);
  const { queue, decoded, until } = queueOf(source);
  queue.need(chunks.slice(0, 1));
  await until(() => source.calls.length === 1);
  queue.need([]);
  queue.need(chunks.slice(0, 1));
  expect(source.calls[0]?.signal.aborted).toBe(true);
  await until(() => source.calls.length === 2);
  source.calls[1]?.give(0);
  source.calls[1]?.end();
  await until(() => decoded.length === 1);
  expect(decoded).toEqual([chunks[0]?.handle]);
});

it("closing a queue aborts all its requests", async () => {
  const source = new HeldSource(file);
  const { queue, until } = queueOf(source);
  queue.need(chunks);
  await until(() => source.calls.length === 2);
  queue.close();
  expect(source.calls.map((call) => call.signal.aborted)).toEqual([true, true]);
});
