/** Plays a series in Chromium, on an empty page with the modules of web/, over a throttled network. */
import type { Browser } from "@playwright/test";
import type * as StreamModule from "../../../web/stream/index.ts";
import type * as ViewerModule from "../../../web/viewer/index.ts";
import type { Link } from "../stream/visit.ts";

export interface PlayedSeries {
  /** The page's address, whose /v1 leads to the server. */
  origin: string;
  /** The names of the steps' volumes. */
  volumes: readonly string[];
  isovalue: number;
  rate: number;
  link: Link;
}

/** The measurements of one loop. */
export interface Loop {
  seconds: number;
  requests: number;
  bytes: number;
  /** The number of stops and their seconds, in which no surface of the next step had arrived. */
  stops: number;
  stopped: number;
  /** The numbers of frames, of frames without a surface, and of steps that were not drawn. */
  frames: number;
  blank: number;
  undrawn: number;
}

export interface Played {
  /** Bytes until the first step is complete. */
  firstBytes: number;
  firstRequests: number;
  /** The viewer's estimate of the bytes of all steps. */
  costBytes: number;
  /** The size of cells in pixels that was chosen. */
  cellPixels: number;
  loops: Loop[];
  /** The most resident samples of all steps, of the page's budget. */
  samples: number;
  sampleBudget: number;
}

export async function playSeries(
  browser: Browser,
  series: PlayedSeries,
  loops: number,
): Promise<Played> {
  const context = await browser.newContext({ viewport: { width: 600, height: 600 } });
  try {
    const page = await context.newPage();
    // tsx names functions by a helper, which the page does not have.
    await page.addInitScript("globalThis.__name = (named) => named");
    await page.goto(`${series.origin}/empty`);
    // The modules arrive before the link becomes slow, because they are not part of the
    // measurement.
    await page.evaluate(async (base) => {
      const modules = await Promise.all([
        import(`${base}/viewer/index.ts`),
        import(`${base}/stream/index.ts`),
      ]);
      const [{ Viewer }] = modules as [typeof ViewerModule, typeof StreamModule];
      const canvas = document.querySelector("canvas");
      if (!canvas) throw new Error("no canvas");
      canvas.style.cssText = "width: 512px; height: 512px";
      const viewer = new Viewer(canvas);
      await viewer.prepare();
      Object.assign(window, { viewer, modules });
    }, series.origin);
    const cdp = await context.newCDPSession(page);
    const bytesPerSecond = (series.link.megabitsPerSecond * 1e6) / 8;
    await cdp.send("Network.emulateNetworkConditions", {
      offline: false,
      latency: series.link.latencyMs,
      downloadThroughput: bytesPerSecond,
      uploadThroughput: bytesPerSecond,
    });
    return await page.evaluate(play, { ...series, loops });
  } finally {
    await context.close();
  }
}

/** Runs in the page. */
async function play(series: PlayedSeries & { loops: number }): Promise<Played> {
  const { viewer, modules } = window as unknown as {
    viewer: ViewerModule.Viewer;
    modules: [typeof ViewerModule, typeof StreamModule];
  };
  const [, { ServerSource }] = modules;
  const base = series.origin;
  const sources: StreamModule.Source[] = [];
  const count = series.volumes.length;
  viewer.setTime({ values: series.volumes.map((_, step) => step) });
  const { time } = viewer;
  if (!time) throw new Error("no time");
  await viewer.addLayer(
    (step) => {
      const source = new ServerSource({ base, volume: series.volumes[step] ?? "" });
      sources.push(source);
      return source;
    },
    { surfaces: [{ isovalue: series.isovalue, colour: "#d9ccb3", opacity: 1 }] },
  );
  const settled = async () => {
    await new Promise((next) => requestAnimationFrame(next));
    while (viewer.isBusy) await new Promise((next) => setTimeout(next, 20));
  };
  const sum = (of: (source: StreamModule.Source) => number) =>
    sources.reduce((all, source) => all + of(source), 0);
  const requests = () => sum((source) => source.requests);
  const bytes = () => sum((source) => source.bytesReceived);
  await settled();
  const [firstRequests, firstBytes] = [requests(), bytes()];
  const costBytes = time.cost?.bytes ?? 0;

  let samples = 0;
  let loop: Loop | undefined;
  let drawn = new Set<number>();
  viewer.on("frame", (frame) => {
    samples = Math.max(samples, frame.samplesResident);
    if (!loop) return;
    ++loop.frames;
    if (frame.samplesDrawn === 0) ++loop.blank;
    drawn.add(time.step);
  });
  let since = 0;
  time.on("buffering", (isBuffering) => {
    if (isBuffering) since = performance.now();
    else if (loop) {
      ++loop.stops;
      loop.stopped += (performance.now() - since) / 1000;
    }
  });
  time.rate = series.rate;
  const results: Loop[] = [];
  for (let i = 0; i < series.loops; ++i) {
    const [requestsBefore, bytesBefore, begin] = [requests(), bytes(), performance.now()];
    const now = {
      seconds: 0,
      requests: 0,
      bytes: 0,
      stops: 0,
      stopped: 0,
      frames: 0,
      blank: 0,
      undrawn: 0,
    };
    loop = now;
    drawn = new Set();
    await new Promise<void>((resolve) => {
      let left = count;
      const off = time.on("step", () => {
        if (--left > 0) return;
        off();
        // The last step counts when it has been drawn.
        const end = viewer.on("frame", () => {
          end();
          resolve();
        });
      });
      time.play();
    });
    now.seconds = (performance.now() - begin) / 1000;
    now.requests = requests() - requestsBefore;
    now.bytes = bytes() - bytesBefore;
    now.undrawn = count - drawn.size;
    results.push(now);
  }
  const { cellPixels } = time;
  time.pause();
  const sampleBudget = viewer.progress?.sampleBudget ?? 0;
  viewer.dispose();
  return {
    firstBytes,
    firstRequests,
    costBytes,
    cellPixels,
    loops: results,
    samples,
    sampleBudget,
  };
}
