import type { Chunk } from "../core/index.ts";
import { measured } from "./timeline.ts";

/** The main thread hands on chunks for at most so long in a frame … (ms) */
const timePerFrame = 2;
/** … and at most so many samples: 4 MB to upload. */
const samplesPerFrame = 256 * 1024;
/** A hidden page draws no frames, but streaming goes on. */
const longestFrame = 100;

interface QueuedUpload {
  chunk: Chunk;
  samples: Uint32Array;
  pinned: boolean;
}

/** Hands decoded chunks on, spread over frames. */
export class UploadQueue {
  readonly #upload: (chunk: Chunk, samples: Uint32Array, pinned: boolean) => void;
  readonly #uploaded: () => void;
  readonly #waiting: QueuedUpload[] = [];
  readonly #handles = new Set<number>();
  #scheduled: (() => void) | undefined;
  #whenEmpty: (() => void)[] = [];
  #closed = false;

  /** `uploaded` is called once after those of a frame. */
  constructor(
    upload: (chunk: Chunk, samples: Uint32Array, pinned: boolean) => void,
    uploaded: () => void,
  ) {
    this.#upload = upload;
    this.#uploaded = uploaded;
  }

  get empty(): boolean {
    return this.#waiting.length === 0;
  }

  /** Resolves when everything added so far has been handed on. */
  drained(): Promise<void> {
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

  readonly #frame = (): void => measured("isosplat:streaming", () => this.#uploadSome());

  #uploadSome(): void {
    this.#scheduled = undefined;
    const until = performance.now() + timePerFrame;
    let samples = 0;
    let upload = this.#waiting.shift();
    while (upload) {
      this.#handles.delete(upload.chunk.handle);
      this.#upload(upload.chunk, upload.samples, upload.pinned);
      if (this.#closed) return;
      samples += upload.samples.length / 4;
      const next = this.#waiting[0];
      const isFull =
        next !== undefined &&
        (performance.now() >= until || samples + next.samples.length / 4 > samplesPerFrame);
      upload = isFull ? undefined : this.#waiting.shift();
    }
    if (this.#waiting.length > 0) this.#scheduled = nextFrame(this.#frame);
    this.#uploaded();
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
