/**
 * Measures visits to pages that show an isosurface, of Isosplat or of a peer: times, bytes and
 * memory.
 */
import { MemoryWatch, processOf } from "../../bench/drop/processes.ts";
import type { Bench } from "../../bench/harness/benchmark.ts";
import { type Link, launch, Visitor } from "../../bench/stream/visit.ts";

/** A page that shows the volume, and globalThis.changeIsovalue(isovalue), which shows another one. */
export interface Program {
  /** With its version. */
  name: string;
  url: string;
  /** Marks of the first and the final picture. */
  first: string;
  final: string;
  /** Defines changeIsovalue if the page does not. */
  prepare?: (visitor: Visitor) => Promise<void>;
  /** Of the page; what remains for the picture has the same size in all programs. */
  viewport: { width: number; height: number };
  /** Whether another isovalue's first picture is followed by more with the mark `final`. */
  refines?: boolean;
}

interface Pictures {
  pictures: { name: string; at: number }[];
  pictureFinished: () => Promise<number>;
  changeIsovalue: (isovalue: number) => Promise<void> | void;
}

/**
 * The simulated link slows the requests of a page, but not those of its service worker, so no
 * service worker is used.
 */
async function bypassServiceWorker({ page }: Visitor): Promise<void> {
  const session = await page.context().newCDPSession(page);
  await session.send("Network.enable");
  await session.send("Network.setBypassServiceWorker", { bypass: true });
}

/**
 * Records for each mark the time at which the GPU has finished the picture of the second frame
 * after it.
 */
async function watchPictures(visitor: Visitor, marks: string[]): Promise<void> {
  await visitor.page.addInitScript((marks) => {
    performance.setResourceTimingBufferSize(5000);
    const contexts = new Set<WebGL2RenderingContext>();
    const original = HTMLCanvasElement.prototype.getContext as (...args: unknown[]) => unknown;
    HTMLCanvasElement.prototype.getContext = function (
      this: HTMLCanvasElement,
      ...args: unknown[]
    ) {
      const context = original.apply(this, args);
      if (context instanceof WebGL2RenderingContext) contexts.add(context);
      return context;
    } as typeof HTMLCanvasElement.prototype.getContext;
    const found = globalThis as unknown as Pictures;
    found.pictures = [];
    found.pictureFinished = async () => {
      for (let i = 0; i < 2; ++i) await new Promise((next) => requestAnimationFrame(next));
      for (const gl of contexts) {
        // Reading waits for the GPU, provided that it reads into memory and from the canvas.
        const buffer = gl.getParameter(gl.PIXEL_PACK_BUFFER_BINDING);
        const target = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
        gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
        gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
        gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target);
      }
      return performance.now();
    };
    new PerformanceObserver((list) => {
      for (const { name } of list.getEntries()) {
        if (!marks.includes(name)) continue;
        found.pictureFinished().then((at) => found.pictures.push({ name, at }));
      }
    }).observe({ type: "mark", buffered: true });
  }, marks);
}

/** When the picture of a mark was finished, in ms; `after`: only pictures later than this. */
async function picture(visitor: Visitor, name: string, after = 0): Promise<number> {
  const handle = await visitor.page.waitForFunction(
    ({ name, after }) =>
      (globalThis as unknown as Pictures).pictures.find(
        (entry) => entry.name === name && entry.at > after,
      ),
    { name, after },
    { timeout: 180_000, polling: 20 },
  );
  return ((await handle.jsonValue()) as { at: number }).at;
}

/** Megabytes of the requests until a mark: for the program and for the data. */
async function megabytesUntil(visitor: Visitor, name: string): Promise<number> {
  const { at } = await visitor.mark(name);
  // Isosplat's marks state the bytes of the volume that have arrived.
  const data = await visitor.page.evaluate((name) => {
    const [mark] = performance.getEntriesByName(name, "mark") as PerformanceMark[];
    return (mark?.detail as { bytesReceived?: number } | null)?.bytesReceived ?? 0;
  }, name);
  return ((await visitor.programBytes(at)) + data) / 1e6;
}

/** Shows another isovalue. Returns the times of the change and of its first and final pictures. */
async function change(visitor: Visitor, program: Program, isovalue: number) {
  await program.prepare?.(visitor);
  // All programs have the same time for fetching in advance.
  await visitor.page.waitForTimeout(1500);
  const now = async () => ((await visitor.programBytes()) + visitor.data.bytes) / 1e6;
  const before = await now();
  const { begin, first } = await visitor.page.evaluate(async (isovalue) => {
    const page = globalThis as unknown as Pictures;
    const begin = performance.now();
    await page.changeIsovalue(isovalue);
    return { begin, first: await page.pictureFinished() };
  }, isovalue);
  const final = program.refines ? await picture(visitor, program.final, begin) : first;
  return {
    first: (first - begin) / 1000,
    final: (final - begin) / 1000,
    megabytes: (await now()) - before,
  };
}

const measures = {
  first: ["first picture", "s"],
  final: ["final picture", "s"],
  firstBytes: ["over the wire until the first picture", "MB"],
  finalBytes: ["over the wire until the final picture", "MB"],
  changeFirst: ["another isovalue, first picture", "s"],
  changeFinal: ["another isovalue, final picture", "s"],
  changeBytes: ["another isovalue, over the wire", "MB"],
  memory: ["memory of the browser's processes, most", "MB"],
} as const;
type Measure = keyof typeof measures;

/** Opens the page with an empty cache, each time in a new browser, and changes the isovalue. */
export async function measureProgram(
  bench: Bench,
  program: Program,
  what: string,
  link: Link,
  next: number,
  runs: number,
): Promise<void> {
  const values = Object.fromEntries(
    Object.keys(measures).map((measure) => [measure, [] as number[]]),
  ) as Record<Measure, number[]>;
  for (let run = 0; run < runs; ++run) {
    const browser = await launch();
    try {
      const visitor = await Visitor.arrive(browser, link, program.viewport);
      await watchPictures(visitor, [program.first, program.final]);
      await bypassServiceWorker(visitor);
      const memory = new MemoryWatch(await processOf(browser));
      await visitor.page.goto(program.url);
      values.first.push((await picture(visitor, program.first)) / 1000);
      values.final.push((await picture(visitor, program.final)) / 1000);
      values.firstBytes.push(await megabytesUntil(visitor, program.first));
      values.finalBytes.push(await megabytesUntil(visitor, program.final));
      const changed = await change(visitor, program, next);
      values.changeFirst.push(changed.first);
      values.changeFinal.push(changed.final);
      values.changeBytes.push(changed.megabytes);
      values.memory.push(memory.end());
    } finally {
      await browser.close();
    }
  }
  for (const [measure, [name, unit]] of Object.entries(measures)) {
    bench.report(`${what}, ${link.name}, ${program.name}`, name, unit, values[measure as Measure]);
  }
}
