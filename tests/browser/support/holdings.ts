/** Counts a page's GPU and browser resources: none may grow because of faults. */
import type { Page } from "@playwright/test";

export interface Holdings {
  /** GL objects that were created and not deleted, of canvases in the document whose context is not lost. */
  glObjects: number;
  /** Of canvases in the document. */
  contexts: number;
  /** Timeouts and intervals that have not fired. */
  timers: number;
  /** Listeners on the window, the document, and the view's canvas. Open sessions have one each. */
  listeners: number;
  workers: number;
}

/**
 * For `page.addInitScript`: counts from the first script on. `window.holdings()` returns the
 * counts.
 */
export function countHoldings(): void {
  // ---- GL objects ----
  const kinds = [
    "Buffer",
    "Texture",
    "Program",
    "Shader",
    "Framebuffer",
    "Renderbuffer",
    "VertexArray",
  ];
  const prototype = WebGL2RenderingContext.prototype as unknown as Record<
    string,
    (...args: unknown[]) => unknown
  >;
  const live = new Map<WebGL2RenderingContext, Set<unknown>>();
  const of = (context: WebGL2RenderingContext): Set<unknown> => {
    let objects = live.get(context);
    if (!objects) {
      const made = new Set<unknown>();
      objects = made;
      live.set(context, made);
      // A lost context frees its objects.
      addListener.call(context.canvas, "webglcontextlost", () => made.clear());
    }
    return objects;
  };
  const wrap = (
    name: string,
    note: (objects: Set<unknown>, object: unknown) => void,
    isOfResult: boolean,
  ): void => {
    const original = prototype[name];
    if (!original) return;
    prototype[name] = function (this: WebGL2RenderingContext, ...args: unknown[]) {
      const result = original.apply(this, args);
      const object = isOfResult ? result : args[0];
      if (object) note(of(this), object);
      return result;
    };
  };
  for (const kind of kinds) {
    wrap(`create${kind}`, (objects, object) => objects.add(object), true);
    wrap(`delete${kind}`, (objects, object) => objects.delete(object), false);
  }
  wrap("fenceSync", (objects, object) => objects.add(object), true);
  wrap("deleteSync", (objects, object) => objects.delete(object), false);

  // ---- Timers ----
  const timers = new Set<number>();
  const { setTimeout: startTimeout, setInterval: startInterval } = window;
  const { clearTimeout: endTimeout, clearInterval: endInterval } = window;
  const callable = (handler: TimerHandler): ((...args: unknown[]) => void) =>
    typeof handler === "function" ? (handler as () => void) : () => {};
  window.setTimeout = ((handler: TimerHandler, wait?: number, ...args: unknown[]) => {
    const id = startTimeout(() => {
      timers.delete(id);
      callable(handler)(...args);
    }, wait);
    timers.add(id);
    return id;
  }) as typeof setTimeout;
  window.setInterval = ((handler: TimerHandler, wait?: number, ...args: unknown[]) => {
    const id = startInterval(callable(handler), wait, ...args);
    timers.add(id);
    return id;
  }) as typeof setInterval;
  window.clearTimeout = (id) => {
    timers.delete(Number(id));
    endTimeout(id);
  };
  window.clearInterval = (id) => {
    timers.delete(Number(id));
    endInterval(id);
  };

  // ---- Listeners on objects that live as long as the page ----
  const listeners = new Map<string, Set<unknown>>();
  const isCounted = (target: EventTarget): boolean =>
    target === window ||
    target === document ||
    (target instanceof HTMLCanvasElement && target.className === "view");
  const keyOf = (target: EventTarget, type: string, options: unknown): string => {
    const name = target === window ? "window" : target === document ? "document" : "canvas";
    const capture =
      typeof options === "object" ? (options as EventListenerOptions)?.capture : options;
    return `${name} ${type} ${Boolean(capture)}`;
  };
  const addListener = EventTarget.prototype.addEventListener;
  const removeListener = EventTarget.prototype.removeEventListener;
  EventTarget.prototype.addEventListener = function (this: EventTarget, type, listener, options) {
    addListener.call(this, type, listener, options);
    const target = this ?? window;
    if (!listener || !isCounted(target)) return;
    const key = keyOf(target, type, options);
    const known = listeners.get(key) ?? new Set();
    listeners.set(key, known.add(listener));
    if (typeof options !== "object") return;
    const forget = (): void => void known.delete(listener);
    if (options.once) addListener.call(target, type, forget, { once: true });
    if (options.signal) addListener.call(options.signal, "abort", forget, { once: true });
  };
  EventTarget.prototype.removeEventListener = function (
    this: EventTarget,
    type,
    listener,
    options,
  ) {
    removeListener.call(this, type, listener, options);
    const target = this ?? window;
    if (isCounted(target)) listeners.get(keyOf(target, type, options))?.delete(listener);
  };

  // A canvas outside of the document belongs to a viewer that has ended: the pictures of suggested isovalues.
  const isShown = ({ canvas }: WebGL2RenderingContext): boolean =>
    canvas instanceof HTMLCanvasElement && canvas.isConnected;
  (window as unknown as { holdings: () => Omit<Holdings, "workers"> }).holdings = () => ({
    glObjects: [...live].reduce((sum, [gl, made]) => sum + (isShown(gl) ? made.size : 0), 0),
    contexts: [...live.keys()].filter(isShown).length,
    timers: timers.size,
    listeners: [...listeners.values()].reduce((sum, known) => sum + known.size, 0),
  });
}

export async function holdingsOf(page: Page): Promise<Holdings> {
  const inPage = await page.evaluate(() =>
    (window as unknown as { holdings: () => Omit<Holdings, "workers"> }).holdings(),
  );
  return { ...inPage, workers: page.workers().length };
}

/** Size of the JavaScript heap, after garbage collection. */
export async function heapBytes(page: Page): Promise<number> {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  await session.detach();
  return usedSize;
}
