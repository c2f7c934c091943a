import { describe, expect, test } from "vitest";
import { MergedRanges } from "../../web/scene/merged_ranges.ts";

interface Request {
  offset: number;
  bytes: number;
  signal: AbortSignal;
  /** Sends the bytes in parts of this size, and ends. */
  answer(partBytes?: number): void;
  fail(error: Error): void;
}

const content = Uint8Array.from({ length: 1 << 21 }, (_, i) => (i * 7 + (i >> 8)) & 255);
const unwanted = new AbortController().signal;

/** A file whose requests are answered by the test. */
function fileOf(concurrency: number) {
  const requests: Request[] = [];
  const file = {
    concurrency,
    range: (
      offset: number,
      bytes: number,
      signal: AbortSignal,
      arrived: (part: Uint8Array, at: number) => void,
    ) =>
      new Promise<void>((resolve, fail) => {
        const answer = (partBytes = bytes) => {
          for (let at = offset; at < offset + bytes; at += partBytes) {
            arrived(content.subarray(at, Math.min(at + partBytes, offset + bytes)), at);
          }
          resolve();
        };
        signal.addEventListener("abort", () => fail(signal.reason));
        requests.push({ offset, bytes, signal, answer, fail });
      }),
  };
  return { file, requests };
}

/** Reads a range, and resolves with its bytes. */
async function read(
  merged: MergedRanges,
  offset: number,
  bytes: number,
  signal = unwanted,
): Promise<Uint8Array> {
  const found = new Uint8Array(bytes);
  let next = offset;
  await merged.range(offset, bytes, signal, (part, at) => {
    expect(at).toBe(next);
    next += part.length;
    found.set(part, at - offset);
  });
  expect(next).toBe(offset + bytes);
  return found;
}

const turn = () => new Promise((resolve) => setTimeout(resolve, 0));
const placeOf = ({ offset, bytes }: Request) => [offset, bytes];

describe("ranges of many readers", () => {
  test("waiting ranges are fetched together if they are near, and each reader gets its own", async () => {
    const { file, requests } = fileOf(1);
    const merged = new MergedRanges(file);
    const places = [
      [500_000, 10],
      [1000, 100],
      [1200, 50],
      [1150, 100],
      [900_000, 5],
      [900, 20],
    ] as const;
    const reading = places.map(([offset, bytes]) => read(merged, offset, bytes));
    await turn();
    expect(requests.map(placeOf)).toEqual([[500_000, 10]]);
    requests[0]?.answer();
    await turn();
    expect(requests.slice(1).map(placeOf)).toEqual([[900, 350]]);
    requests[1]?.answer(7);
    await turn();
    expect(requests.slice(2).map(placeOf)).toEqual([[900_000, 5]]);
    requests[2]?.answer();
    for (const [i, [offset, bytes]] of places.entries()) {
      expect(await reading[i]).toEqual(content.subarray(offset, offset + bytes));
    }
  });

  test("no more requests run at a time than the file allows", async () => {
    const { file, requests } = fileOf(3);
    const merged = new MergedRanges(file);
    const reading = Array.from({ length: 8 }, (_, i) => read(merged, i * 100_000, 1));
    await turn();
    expect(requests).toHaveLength(3);
    for (let i = 0; i < 8; ++i) {
      requests[i]?.answer();
      await turn();
      expect(requests).toHaveLength(Math.min(8, 4 + i));
    }
    await Promise.all(reading);
  });

  test("a large group is divided", async () => {
    const { file, requests } = fileOf(1);
    const merged = new MergedRanges(file);
    const size = 100 * 1024;
    const reading = Array.from({ length: 12 }, (_, i) => read(merged, (i * size) / 2, size / 2));
    const large = read(merged, 6 * size, 5 * size);
    await turn();
    expect(requests.map(placeOf)).toEqual([[0, 6 * size]]);
    requests[0]?.answer();
    await turn();
    expect(requests.slice(1).map(placeOf)).toEqual([[6 * size, 5 * size]]);
    requests[1]?.answer(1000);
    await Promise.all([...reading, large]);
  });

  test("aborting a reader does not affect the others; aborting the last one ends the request", async () => {
    const { file, requests } = fileOf(1);
    const merged = new MergedRanges(file);
    const [a, b, c] = [new AbortController(), new AbortController(), new AbortController()];
    const reading = [a, b, c].map(({ signal }, i) => read(merged, 10 * i, 10, signal));
    for (const one of reading) one.catch(() => {});
    await turn();
    expect(placeOf(requests[0] as Request)).toEqual([0, 30]);
    b.abort(new Error("b ends"));
    await expect(reading[1]).rejects.toThrow("b ends");
    expect(requests[0]?.signal.aborted).toBe(false);
    a.abort(new Error("a ends"));
    c.abort(new Error("c ends"));
    await expect(reading[2]).rejects.toThrow("c ends");
    expect(requests[0]?.signal.aborted).toBe(true);
    const ended = new AbortController();
    ended.abort(new Error("ended before"));
    await expect(read(merged, 0, 1, ended.signal)).rejects.toThrow("ended before");
    await turn();
    expect(requests).toHaveLength(1);
  });

  test("a fault is reported to each reader of the request, and later requests work", async () => {
    const { file, requests } = fileOf(1);
    const merged = new MergedRanges(file);
    const reading = [0, 1].map((i) => read(merged, i, 1));
    for (const one of reading) one.catch(() => {});
    await turn();
    requests[0]?.fail(new Error("no network"));
    for (const one of reading) await expect(one).rejects.toThrow("no network");
    const again = read(merged, 3, 4);
    await turn();
    requests[1]?.answer();
    expect(await again).toEqual(content.subarray(3, 7));
  });
});
