/** A visit to the real page in Chromium over a throttled network: its times, bytes and memory. */
import {
  type Browser,
  type BrowserContext,
  type CDPSession,
  chromium,
  type Page,
} from "@playwright/test";
import { launchOptions } from "../../browser/support/chromium.ts";

export interface Link {
  name: string;
  megabitsPerSecond: number;
  latencyMs: number;
}

export const links: Link[] = [
  { name: "20 Mbit/s, 40 ms", megabitsPerSecond: 20, latencyMs: 40 },
  { name: "5 Mbit/s, 150 ms", megabitsPerSecond: 5, latencyMs: 150 },
];

/** The traffic during a period. Bytes are counted on the network, including headers. */
export interface Wire {
  bytes: number;
  requests: number;
}

/** The detail of web/stream's marks. */
export interface MarkDetail {
  bytesReceived: number;
  requests: number;
  samplesResident: number;
  sampleBudget: number;
}

/** Milliseconds. */
export interface Work {
  total: number;
  longest: number;
}

export function launch(): Promise<Browser> {
  return chromium.launch(launchOptions);
}

/** The URLs of a volume's data, on a server or as a file. */
const volumeUrl = /\/v1\/|\.isosplat/;

/** Waits for the page's controls, which load last. */
async function controls(page: Page): Promise<void> {
  await page.waitForFunction(() => customElements.get("wa-slider") !== undefined);
}

async function mainThreadOf(cdp: CDPSession): Promise<{ scripts: number; layout: number }> {
  const { metrics } = await cdp.send("Performance.getMetrics");
  const ms = (wanted: string): number =>
    1000 * (metrics.find(({ name }) => name === wanted)?.value ?? 0);
  return {
    scripts: ms("ScriptDuration"),
    layout: ms("LayoutDuration") + ms("RecalcStyleDuration"),
  };
}

/** A page in a new browser profile, whose cache has only what this visitor has fetched. */
export class Visitor {
  readonly page: Page;
  readonly #context: BrowserContext;
  readonly #cdp: CDPSession;
  /** The requests for the volume's data. */
  readonly data: Wire = { bytes: 0, requests: 0 };
  /** The URLs of these requests, in order. */
  readonly urls: string[] = [];
  #pageUrl = "";
  #ofProcessor: CDPSession | undefined;

  private constructor(context: BrowserContext, page: Page, cdp: CDPSession) {
    this.#context = context;
    this.page = page;
    this.#cdp = cdp;
  }

  static async arrive(
    browser: Browser,
    link?: Link,
    viewport = { width: 1024, height: 768 },
  ): Promise<Visitor> {
    // The network of a service worker would not be throttled.
    const context = await browser.newContext({ viewport, serviceWorkers: "block" });
    const page = await context.newPage();
    const cdp = await context.newCDPSession(page);
    const visitor = new Visitor(context, page, cdp);
    await visitor.#watch();
    if (link) {
      await cdp.send("Network.emulateNetworkConditions", {
        offline: false,
        latency: link.latencyMs,
        downloadThroughput: (link.megabitsPerSecond * 1e6) / 8,
        uploadThroughput: (link.megabitsPerSecond * 1e6) / 8,
      });
    }
    // tsx names functions by a helper, which the page does not have.
    await page.addInitScript("globalThis.__name = (named) => named");
    // The marks of web/stream and of benchmarks, with the time at which the next frame was submitted to the
    // browser. For the first surface of a layer, and the first values of a field, that is the frame after the next picture.
    await page.addInitScript(() => {
      interface Seen {
        name: string;
        at: number;
        shown: number;
      }
      const seen: Seen[] = [];
      (globalThis as unknown as { visit: Seen[] }).visit = seen;
      const undrawn = new Set<Seen>();
      const submitted = (entries: readonly Seen[]): void => {
        requestAnimationFrame(() =>
          requestAnimationFrame(() => {
            for (const entry of entries) entry.shown = performance.now();
          }),
        );
      };
      new PerformanceObserver((list) => {
        for (const { name, startTime } of list.getEntries()) {
          if (!/^(isosplat|vtk|peer|bench):/.test(name)) continue;
          const entry = { name, at: startTime, shown: 0 };
          seen.push(entry);
          if (/^isosplat:(surface|coloured)$/.test(name)) undrawn.add(entry);
          else submitted([entry]);
        }
      }).observe({ type: "mark", buffered: true });
      new PerformanceObserver((list) => {
        for (const { startTime } of list.getEntriesByName("isosplat:drawing")) {
          const drawn = [...undrawn].filter(({ at }) => at <= startTime);
          for (const entry of drawn) undrawn.delete(entry);
          submitted(drawn);
        }
      }).observe({ type: "measure", buffered: true });
      const memories: WebAssembly.Memory[] = [];
      (globalThis as unknown as { memories: typeof memories }).memories = memories;
      const instantiate = WebAssembly.instantiate;
      WebAssembly.instantiate = (async (
        program: WebAssembly.Module | BufferSource,
        imports: WebAssembly.Imports,
      ) => {
        // If it is called with bytes instead of a module, the result contains the instance and the
        // module.
        const answer = (await instantiate(program as BufferSource, imports)) as
          | WebAssembly.Instance
          | WebAssembly.WebAssemblyInstantiatedSource;
        const { exports } = "instance" in answer ? answer.instance : answer;
        for (const exported of Object.values(exports)) {
          if (exported instanceof WebAssembly.Memory) memories.push(exported);
        }
        return answer;
      }) as typeof WebAssembly.instantiate;
      const work: Record<string, Work> = {};
      (globalThis as unknown as { work: typeof work }).work = work;
      new PerformanceObserver((list) => {
        for (const { name, duration } of list.getEntries()) {
          work[name] ??= { total: 0, longest: 0 };
          work[name].total += duration;
          work[name].longest = Math.max(work[name].longest, duration);
        }
      }).observe({ type: "measure", buffered: true });
    });
    return visitor;
  }

  async #watch(): Promise<void> {
    const dataRequests = new Set<string>();
    const cached = new Set<string>();
    const isCounted = (id: string): boolean => dataRequests.has(id) && !cached.has(id);
    await this.#cdp.send("Network.enable");
    await this.#cdp.send("Performance.enable");
    this.#cdp.on("Network.requestWillBeSent", ({ requestId, request }) => {
      if (!request.url.startsWith("http")) return;
      if (!this.#pageUrl) this.#pageUrl = request.url;
      if (!volumeUrl.test(request.url)) return;
      dataRequests.add(requestId);
      this.urls.push(request.url);
    });
    this.#cdp.on("Network.requestServedFromCache", ({ requestId }) => cached.add(requestId));
    this.#cdp.on("Network.responseReceived", ({ requestId, response }) => {
      if (response.fromDiskCache) cached.add(requestId);
      if (isCounted(requestId)) ++this.data.requests;
    });
    // encodedDataLength of dataReceived is 0 for some responses; loadingFinished reports the total.
    const partial = new Map<string, number>();
    this.#cdp.on("Network.dataReceived", ({ requestId, encodedDataLength }) => {
      if (!isCounted(requestId)) return;
      this.data.bytes += encodedDataLength;
      partial.set(requestId, (partial.get(requestId) ?? 0) + encodedDataLength);
    });
    this.#cdp.on("Network.loadingFinished", ({ requestId, encodedDataLength }) => {
      if (!isCounted(requestId)) return;
      this.data.bytes += encodedDataLength - (partial.get(requestId) ?? 0);
    });
  }

  /** Waits for a mark of web/stream. shown: time (ms) at which the frame with it was submitted. */
  async mark(name: string, count = 1, timeout = 180_000): Promise<{ at: number; shown: number }> {
    const handle = await this.page.waitForFunction(
      ({ name, count }) => {
        const seen = (
          globalThis as unknown as { visit: { name: string; at: number; shown: number }[] }
        ).visit.filter((entry) => entry.name === name && entry.shown > 0);
        return seen[count - 1];
      },
      { name, count },
      { timeout, polling: 20 },
    );
    return (await handle.jsonValue()) as { at: number; shown: number };
  }

  /** The size on the network of the page's response whose URL has this ending. */
  async bytesOf(ending: string): Promise<number> {
    return this.page.evaluate((ending) => {
      const all = performance.getEntriesByType("resource") as PerformanceResourceTiming[];
      return all.find(({ name }) => new URL(name).pathname.endsWith(ending))?.transferSize ?? 0;
    }, ending);
  }

  /**
   * Moves the isovalue slider to these positions (0 to 1) one after the other, as a user would, and
   * waits for a number of frames after each; the first of these draws it. It makes one call into
   * the page for all positions, so that the cost of calls is not measured.
   */
  async slide(places: readonly number[], framesEach = 0): Promise<void> {
    await this.page.evaluate(
      async ({ places, framesEach }) => {
        const slider = document.querySelector<HTMLInputElement>(".isovalue-slider");
        if (!slider) throw new Error("the page has no isovalue slider");
        for (const place of places) {
          slider.valueAsNumber =
            Number(slider.min) + place * (Number(slider.max) - Number(slider.min));
          slider.dispatchEvent(new Event("input", { bubbles: true }));
          for (let i = 0; i < framesEach; ++i) {
            await new Promise((next) => requestAnimationFrame(next));
          }
        }
      },
      { places, framesEach },
    );
  }

  /**
   * Memory of the page's main thread after garbage collection, in MB: objects, array buffers, and
   * WebAssembly memories. Does not include workers, which tests/web/stream.spec.ts checks.
   */
  async heap(): Promise<{ objects: number; buffers: number; wasm: number }> {
    await this.#cdp.send("HeapProfiler.collectGarbage");
    const usage = await this.#cdp.send("Runtime.getHeapUsage");
    const wasm = await this.page.evaluate(() => {
      const { memories } = globalThis as unknown as { memories: WebAssembly.Memory[] };
      return memories.reduce((bytes, memory) => bytes + memory.buffer.byteLength, 0);
    });
    const [objects, buffers] = [usage.usedSize, usage.backingStorageSize];
    return { objects: objects / 1e6, buffers: buffers / 1e6, wasm: wasm / 1e6 };
  }

  /**
   * Milliseconds that the main thread has spent so far on scripts (with WebAssembly), and on layout and
   * styles.
   */
  async mainThread(): Promise<{ scripts: number; layout: number }> {
    return mainThreadOf(this.#cdp);
  }

  /**
   * Like `mainThread`, but as processor time: on a machine with few cores, other threads interrupt
   * this one.
   */
  async processorTime(): Promise<{ scripts: number; layout: number }> {
    if (!this.#ofProcessor) {
      this.#ofProcessor = await this.#context.newCDPSession(this.page);
      await this.#ofProcessor.send("Performance.enable", { timeDomain: "threadTicks" });
    }
    return mainThreadOf(this.#ofProcessor);
  }

  /** Time that the main thread has spent so far on a kind of work (web/stream/timeline.ts), in ms. */
  async work(name: "isosplat:streaming" | "isosplat:drawing"): Promise<Work> {
    return this.page.evaluate((name) => {
      const { work } = globalThis as unknown as { work: Record<string, Work> };
      return work[name] ?? { total: 0, longest: 0 };
    }, name);
  }

  /** The state of streaming at the last mark of this name. */
  async markDetail(name: string): Promise<MarkDetail> {
    return this.page.evaluate((name) => {
      const [mark] = performance.getEntriesByName(name, "mark");
      return (mark as PerformanceMark).detail;
    }, name);
  }

  /** Removes the volume's data from the browser's cache, but not the page. */
  async forgetData(): Promise<void> {
    await this.page.goto("about:blank");
    await this.#cdp.send("Network.clearBrowserCache");
    // The cache can only be cleared completely, so another tab fetches the page again.
    const before = this.page.context().pages().length;
    const again = await this.page.context().newPage();
    const cdp = await this.#context.newCDPSession(again);
    await cdp.send("Network.enable");
    await cdp.send("Network.setBlockedURLs", { urls: ["*/v1/*", "*.isosplat"] });
    await again.goto(this.#pageUrl);
    await controls(again);
    await again.waitForLoadState("networkidle");
    await again.close();
    if (this.page.context().pages().length !== before) throw new Error("a page was left open");
  }

  /** Waits until the page's controls are defined. The page loads them after the first surface. */
  async controls(): Promise<void> {
    await controls(this.page);
  }

  /**
   * Bytes on the wire of the page's own files (without the volume) that were requested before a
   * time (ms, as in mark()). The source is resource timing, which includes the workers' script, and
   * counts 300 bytes for the header of each response.
   */
  async programBytes(before = Number.POSITIVE_INFINITY): Promise<number> {
    const files = await this.page.evaluate(() =>
      (
        [
          ...performance.getEntriesByType("navigation"),
          ...performance.getEntriesByType("resource"),
        ] as PerformanceResourceTiming[]
      ).map(({ name, startTime, transferSize }) => ({ name, startTime, transferSize })),
    );
    return files
      .filter(({ name, startTime }) => startTime < before && !volumeUrl.test(name))
      .reduce((bytes, { transferSize }) => bytes + transferSize, 0);
  }

  async leave(): Promise<void> {
    await this.#context.close();
  }
}
