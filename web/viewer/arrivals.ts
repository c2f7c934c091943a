import type { Progress } from "../stream/types.ts";
import { ArrivalForecast } from "./arrival_forecast.ts";

/**
 * The first picture waits this long (ms) for the first surface of a further layer, and this long in all while they
 * keep arriving.
 */
const longestPartial = { each: 300, all: 1500 };

/** Decides how long a picture waits for data that are still to arrive. All times are in ms. */
export class Arrivals {
  readonly #forecast = new ArrivalForecast();
  readonly #missing: () => number;
  #begunAt: number | null = null;
  /** The number of missing first surfaces, and the time at which the last one was seen to arrive. */
  #partial = { missing: 0, since: 0 };
  #hasPicture = false;
  #chunksToGo = 0;
  /** While more data are expected, new chunks are not drawn before this time. */
  #nextPicture = 0;

  /** missing: the number of layers whose first surface is still to arrive. */
  constructor(missing: () => number) {
    this.#missing = missing;
  }

  /**
   * Whether something is visible, or it is known that there is nothing to see. Before that, drawing would
   * waste the GPU's time.
   */
  get isBegun(): boolean {
    return this.#begunAt !== null;
  }

  /** Whether more chunks are expected for the present view. */
  get areExpected(): boolean {
    return this.#chunksToGo > 0;
  }

  /** Whether there is something to draw, and nothing was drawn. */
  get lacksPicture(): boolean {
    return this.isBegun && !this.#hasPicture;
  }

  begin(now: number): void {
    if (this.#begunAt !== null) return;
    this.#begunAt = now;
    this.#partial = { missing: this.#missing(), since: now };
  }

  /** The progress of streaming has changed. Returns whether the last expected chunk has arrived. */
  progressed(now: number, { chunksToGo, bytesFetched, bytesToGo }: Progress): boolean {
    this.#forecast.add(now, bytesFetched, bytesToGo);
    const isLast = this.areExpected && chunksToGo === 0;
    this.#chunksToGo = chunksToGo;
    return isLast;
  }

  /** A picture was drawn. */
  pictureDrawn(): void {
    this.#hasPicture = true;
  }

  /** The GPU has finished a picture, which took this long. */
  drawn(now: number, milliseconds: number): void {
    this.#nextPicture = now + milliseconds;
  }

  /**
   * The time until the first picture may be drawn. It waits for the first surfaces of all layers, since a
   * picture without some of them would mostly delay the picture with them.
   */
  waitOfFirst(now: number): number {
    if (this.#hasPicture || this.#begunAt === null) return 0;
    const missing = this.#missing();
    if (missing === 0) return 0;
    this.#partial = { missing, since: missing < this.#partial.missing ? now : this.#partial.since };
    const { each, all } = longestPartial;
    return Math.max(0, Math.min(this.#partial.since + each, this.#begunAt + all) - now);
  }

  /**
   * The time until a picture with new chunks may be drawn. If more are expected, they wait for the duration of
   * a picture (milliseconds): a slow GPU would otherwise draw again after every few chunks, and software
   * renderers would take the time that decoding needs. They wait for the last chunk if it is expected soon,
   * since a picture without it would mostly delay the picture with it.
   */
  wait(now: number, milliseconds: number): number {
    const first = this.waitOfFirst(now);
    if (!this.areExpected) return first;
    return Math.max(first, this.#nextPicture - now, this.#forecast.wait(now, milliseconds));
  }

  /** The next picture is unrelated to the present one. */
  forget(): void {
    this.#begunAt = null;
    this.#hasPicture = false;
    this.#chunksToGo = 0;
    this.#forecast.forget();
  }
}
