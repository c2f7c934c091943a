/** How often failed requests are repeated. The tests control the clock. */
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Backoff } from "../../web/stream/backoff.ts";
import { FailedParts } from "../../web/stream/failed_parts.ts";
import { longestSlowRetry, StreamError } from "../../web/stream/index.ts";

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

/** The shortest allowed time between two attempts. */
const shortestGap = 10_000;
/** The longest allowed time until a repaired source is noticed. */
const longestGap = 20_000;

const gaps = (times: readonly number[]): number[] =>
  times.slice(1).map((time, i) => time - (times[i] ?? 0));

/** The times at which a source that always fails is tried, within this many ms. */
async function tries(kind: "not-found" | "unreachable", milliseconds: number): Promise<number[]> {
  const backoff = new Backoff({ trouble: () => {} });
  const ending = new AbortController();
  const times: number[] = [];
  const attempt = (): Promise<void> => {
    times.push(Date.now());
    return Promise.reject(new StreamError(kind, "it always does"));
  };
  const tried = backoff.retry(ending.signal, attempt, { slowly: true });
  tried.catch(() => {});
  await vi.advanceTimersByTimeAsync(milliseconds);
  ending.abort();
  backoff.close();
  return times;
}

test("slow retries come after 12 s, 14 s, and then every 16 s", async () => {
  const seconds = gaps(await tries("not-found", 80_000)).map((gap) => Math.round(gap / 1000));
  expect(seconds).toEqual([12, 14, 16, 16, 16]);
  expect(longestSlowRetry).toBeLessThan(longestGap);
});

test("retries of the kind soon slow down to one attempt in ten seconds", async () => {
  const times = await tries("unreachable", 120_000);
  const late = gaps(times.filter((time) => time - (times[0] ?? 0) > 20_000));
  expect(late.length).toBeGreaterThan(5);
  expect(Math.min(...late)).toBeGreaterThanOrEqual(shortestGap);
  expect(Math.max(...gaps(times))).toBeLessThan(longestGap);
});

test("if an intact store hastens a retry, and the retry fails, later retries are slow", async () => {
  let hastened = 0;
  const backoff = new Backoff({
    trouble: () => {},
    // A session does this if it finds that the store at its address is intact.
    slow: () => {
      ++hastened;
      backoff.hasten();
    },
  });
  const ending = new AbortController();
  const times: number[] = [];
  let isInOrder = false;
  const attempt = (): Promise<void> => {
    times.push(Date.now());
    // In a loop of requests, the clock would never advance.
    if (isInOrder || times.length > 20) return Promise.resolve();
    return Promise.reject(new StreamError("not-found", "a directory page is missing"));
  };
  const tried = backoff.retry(ending.signal, attempt, { slowly: true });
  tried.catch(() => {});
  await vi.advanceTimersByTimeAsync(60_000);
  // The first retry is at once, and later ones are slow.
  expect(hastened).toBe(times.length);
  expect(gaps(times)[0]).toBeLessThan(1000);
  expect(Math.min(...gaps(times).slice(1))).toBeGreaterThanOrEqual(shortestGap);
  isInOrder = true;
  await vi.advanceTimersByTimeAsync(longestGap);
  await tried;
  backoff.close();
});

test("damaged parts are retried slowly, one at a time", async () => {
  for (const parts of [["a"], ["a", "b", "c"]]) {
    const looks: { part: string; at: number }[] = [];
    const isDamaged = new StreamError("damaged-part", "its checksum differs");
    const second = new FailedParts<string>(
      () => true,
      (part) => {
        looks.push({ part, at: Date.now() });
        second.add(part, isDamaged);
      },
    );
    for (const part of parts) second.add(part, isDamaged);
    await vi.advanceTimersByTimeAsync(100_000);
    second.close();
    const seconds = gaps(looks.map(({ at }) => at)).map((gap) => Math.round(gap / 1000));
    expect(seconds).toEqual([14, 16, 16, 16, 16]);
    expect(looks.map(({ part }) => part)).toEqual(looks.map((_, i) => parts[i % parts.length]));
  }
});
