import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { UploadPurpose } from "./residency.ts";
import { measured } from "./timeline.ts";

/** Longest time for uploads in one frame (ms). */
const timePerFrame = 2;
/** Most samples uploaded in one frame: 4 MB. */
const samplesPerFrame = 256 * 1024;
/** A hidden page has no frames. Uploads continue after this time (ms). */
const longestFrame = 100;

interface QueuedUpload {
  chunk: Chunk;
  decoded: DecodedChunk;
  purpose: UploadPurpose;
}

export type Upload = (chunk: Chunk, decoded: DecodedChunk, purpose: UploadPurpose) => void;

/** Uploads decoded chunks, spread over frames. */
export class UploadQueue {
  readonly #upload: Upload;
  readonly #uploaded: () => void;
  readonly #waiting: QueuedUpload[] = [];
  readonly #handles = new Set<number>();
  #scheduled: (() => void) | undefined;
  #whenEmpty: (() => void)[] = [];
  #closed = false;

  /** `uploaded` is called once per frame, after its uploads. */
  constructor(upload: Upload, uploaded: () => void) {
    this.#upload = upload;
    this.#uploaded = uploaded;
  }

  get empty(): boolean {
    return this.#waiting.length === 0;
  }

  /** Resolves when everything added so far has been uploaded. */
  drained(): Promise<void> {
    if (this.empty || this.#closed) return Promise.resolve();
    return new Promise((resolve) => this.#whenEmpty.push(resolve));
  }

  has(handle: number): boolean {
    return this.#handles.has(handle);
  }

  add(chunk: Chunk, decoded: DecodedChunk, purpose: UploadPurpose): void {
    if (this.#closed) return;
    this.#waiting.push({ chunk, decoded, purpose });
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
      this.#upload(upload.chunk, upload.decoded, upload.purpose);
      if (this.#closed) return;
      samples += upload.decoded.samples.length / 4;
      const next = this.#waiting[0];
      const isFull =
        next !== undefined &&
        (performance.now() >= until || samples + next.decoded.samples.length / 4 > samplesPerFrame);
      upload = isFull ? undefined : this.#waiting.shift();
    }
    if (this.#waiting.length > 0) this.#scheduled = nextFrame(this.#frame);
    this.#uploaded();
    if (this.empty) for (const resolve of this.#whenEmpty.splice(0)) resolve();
  }
}

/** Calls back in the next frame, or after `longestFrame`. Returns a function that cancels it. */
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
