/** What goes wrong in tests/browser/chaos.browser.ts: at random, and the same for the same seed. */
import type { Fault } from "../../support/fault_proxy.ts";

/** Numbers in [0, 1): mulberry32, by Tommy Ettinger (public domain). */
export class Chance {
  #state: number;

  constructor(seed: number) {
    this.#state = seed >>> 0;
  }

  next(): number {
    this.#state = (this.#state + 0x6d2b79f5) >>> 0;
    let t = this.#state;
    t = Math.imul(t ^ (t >>> 15), t | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  }

  /** A whole number from `low` to `high`, both included. */
  whole(low: number, high: number): number {
    return low + Math.floor(this.next() * (high - low + 1));
  }

  of<T>(list: readonly T[]): T {
    return list[this.whole(0, list.length - 1)] as T;
  }
}

const statuses = [400, 401, 403, 404, 408, 410, 412, 416, 429, 500, 502, 503, 504];

/** Something that goes wrong with an answer. */
export function anyFault(chance: Chance): Fault {
  switch (chance.whole(0, 6)) {
    case 0:
      return { kind: "reset" };
    case 1:
      return { kind: "truncate", bytes: chance.whole(0, 60_000) };
    case 2:
      return { kind: "corrupt", at: chance.whole(0, 1 << 20) };
    case 3:
      return { kind: "drip", bytes: chance.whole(500, 5000) };
    case 4:
      return { kind: "elsewhere", path: "/v1/volumes/none" };
    case 5:
      return { kind: "status", status: chance.of(statuses) };
    default:
      // Answers overtake each other.
      return { kind: "delay", milliseconds: chance.whole(0, 1500) };
  }
}

/** What the page holds of the GPU and of the browser: it must not grow with what goes wrong. */
export interface Holdings {
  /** GL objects made and not deleted, of the contexts that are not lost. */
  glObjects: number;
  contexts: number;
}

/** For `page.addInitScript`: counts GL objects. `window.holdings()` tells. */
export function countHoldings(): void {
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
      // A lost context takes its objects with it.
      context.canvas.addEventListener("webglcontextlost", () => made.clear());
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
  (window as unknown as { holdings: () => Holdings }).holdings = () => ({
    glObjects: [...live.values()].reduce((sum, objects) => sum + objects.size, 0),
    contexts: live.size,
  });
}
