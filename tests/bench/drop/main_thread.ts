import type { Browser, Page } from "@playwright/test";

interface TraceEvent {
  name: string;
  ph: string;
  ts: number;
  dur?: number;
  pid: number;
  tid: number;
  args?: { name?: string };
}

/**
 * Records the tasks of a page's main thread (Chromium's trace) while `work` runs. Returns the longest
 * one, in milliseconds, without the time in which pictures were drawn: the measures isosplat:drawing.
 * Tasks before the mark `from` and after the mark `to` do not count.
 */
export async function longestTask(
  browser: Browser,
  page: Page,
  { from, to }: { from: string; to: string },
  work: () => Promise<void>,
): Promise<number> {
  const categories = ["toplevel", "blink.user_timing", "__metadata"];
  await browser.startTracing(page, { categories });
  await work();
  const trace = JSON.parse((await browser.stopTracing()).toString()) as {
    traceEvents: TraceEvent[];
  };
  const events = trace.traceEvents;
  const mark = (name: string) => {
    const found = events.find((event) => event.name === name && /^[IRi]$/.test(event.ph));
    if (!found) throw new Error(`the trace has no mark ${name}`);
    return found;
  };
  const [first, last] = [mark(from), mark(to)];
  const drawing = spans(events.filter(({ name }) => name === "isosplat:drawing"));
  const isMain = ({ pid, tid }: TraceEvent) => pid === first.pid && tid === first.tid;
  let longest = 0;
  for (const event of events) {
    const { name, ph, ts, dur = 0 } = event;
    if (ph !== "X" || !name.endsWith("RunTask") || !isMain(event)) continue;
    if (ts < first.ts || ts > last.ts) continue;
    const drawn = drawing.reduce(
      (sum, [begin, end]) => sum + Math.max(0, Math.min(end, ts + dur) - Math.max(begin, ts)),
      0,
    );
    longest = Math.max(longest, (dur - drawn) / 1000);
  }
  return longest;
}

/** Begin and end of measures. */
function spans(events: readonly TraceEvent[]): [number, number][] {
  const begins = events.filter(({ ph }) => ph === "b").map(({ ts }) => ts);
  const ends = events.filter(({ ph }) => ph === "e").map(({ ts }) => ts);
  return begins.map((begin, i) => [begin, ends[i] ?? begin]);
}
