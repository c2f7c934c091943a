import type { Chunk } from "../core/index.ts";
import { measured } from "./timeline.ts";

/** The main thread hands on chunks for at most so long in a frame … (ms) */
const timePerFrame = 2;
/** … and at most so many samples: 4 MB to upload. */
const samplesPerFrame = 256 * 1024;
/** A hidden page draws no frames, but streaming goes on. */
const longestFrame = 100;

interface Delivery {
  chunk: Chunk;
  samples: Uint32Array;
  pinned: boolean;
}

/** Hands decoded chunks on, spread over frames. */
export class Deliveries {
  readonly #deliver: (chunk: Chunk, samples: Uint32Array, pinned: boolean) => void;
  readonly #delivered: () => void;
  readonly #waiting: Delivery[] = [];
  readonly #handles = new Set<number>();
  #scheduled: (() => void) | undefined;
  #whenEmpty: (() => void)[] = [];
  #closed = false;

  /** `delivered` is called once after those of a frame. */
  constructor(
    deliver: (chunk: Chunk, samples: Uint32Array, pinned: boolean) => void,
    delivered: () => void,
  ) {
    this.#deliver = deliver;
    this.#delivered = delivered;
  }

  get empty(): boolean {
    return this.#waiting.length === 0;
  }

  /** Resolves when everything added so far has been handed on. */
  handedOn(): Promise<void> {
    if (this.empty || this.#closed) return Promise.resolve();
    return new Promise((resolve) => this.#whenEmpty.push(resolve));
  }

  has(handle: number): boolean {
    return this.#handles.has(handle);
  }

  add(chunk: Chunk, samples: Uint32Array, pinned: boolean): void {
    if (this.#closed) return;
    this.#waiting.push({ chunk, samples, pinned });
    this.#handles.add(chunk.handle);
    this.#scheduled ??= nextFrame(this.#frame);
  }

  close(): void {
    this.#closed = true;
    this.#scheduled?.();
    this.#waiting.length = 0;
    this.#handles.clear();
    for (const resolve of this.#whenEmpty.splice(0)) resolve();
  }

  readonly #frame = (): void => measured("isosplat:streaming", () => this.#handOn());

  #handOn(): void {
    this.#scheduled = undefined;
    const until = performance.now() + timePerFrame;
    let samples = 0;
    let delivery = this.#waiting.shift();
    while (delivery) {
      this.#handles.delete(delivery.chunk.handle);
      this.#deliver(delivery.chunk, delivery.samples, delivery.pinned);
      if (this.#closed) return;
      samples += delivery.samples.length / 4;
      const next = this.#waiting[0];
      const isFull =
        next !== undefined &&
        (performance.now() >= until || samples + next.samples.length / 4 > samplesPerFrame);
      delivery = isFull ? undefined : this.#waiting.shift();
    }
    if (this.#waiting.length > 0) this.#scheduled = nextFrame(this.#frame);
    this.#delivered();
    if (this.empty) for (const resolve of this.#whenEmpty.splice(0)) resolve();
  }
}

/** Calls back in the next frame, or soon where none comes. Returns how to cancel it. */
function nextFrame(call: () => void): () => void {
  let frame = 0;
  const cancel = (): void => {
    clearTimeout(timer);
    if (frame) cancelAnimationFrame(frame);
  };
  const run = (): void => {
    cancel();
    call();
  };
  const hasFrames = typeof requestAnimationFrame === "function";
  const timer = setTimeout(run, hasFrames ? longestFrame : 0);
  if (hasFrames) frame = requestAnimationFrame(run);
  return cancel;
}
