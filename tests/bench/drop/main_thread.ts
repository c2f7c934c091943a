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

/** The longest task of a page's main thread between two marks, in ms; undefined without such a time. */
export type LongestTask = (from: string, to: string) => number | undefined;

/**
 * Records the tasks of a page's main thread (Chromium's trace) while `work` runs. If marks
 * have the same name, the first one counts. The time of the measures isosplat:drawing, in which pictures
 * were drawn, does not count.
 */
export async function traceTasks(
  browser: Browser,
  page: Page,
  work: () => Promise<void>,
): Promise<LongestTask> {
  const categories = ["toplevel", "blink.user_timing", "__metadata"];
  await browser.startTracing(page, { categories });
  await work();
  const trace = JSON.parse((await browser.stopTracing()).toString()) as {
    traceEvents: TraceEvent[];
  };
  const events = trace.traceEvents;
  const mark = (name: string) =>
    events.find((event) => event.name === name && /^[IRi]$/.test(event.ph));
  const drawing = spans(events.filter(({ name }) => name === "isosplat:drawing"));
  return (from, to) => {
    const [first, last] = [mark(from), mark(to)];
    if (!first || !last || last.ts < first.ts) return undefined;
    let longest = 0;
    for (const { name, ph, ts, dur = 0, pid, tid } of events) {
      if (ph !== "X" || !name.endsWith("RunTask") || pid !== first.pid || tid !== first.tid)
        continue;
      if (ts < first.ts || ts > last.ts) continue;
      const drawn = drawing.reduce(
        (sum, [begin, end]) => sum + Math.max(0, Math.min(end, ts + dur) - Math.max(begin, ts)),
        0,
      );
      longest = Math.max(longest, (dur - drawn) / 1000);
    }
    return longest;
  };
}

/** Begin and end of measures. */
function spans(events: readonly TraceEvent[]): [number, number][] {
  const begins = events.filter(({ ph }) => ph === "b").map(({ ts }) => ts);
  const ends = events.filter(({ ph }) => ph === "e").map(({ ts }) => ts);
  return begins.map((begin, i) => [begin, ends[i] ?? begin]);
}
