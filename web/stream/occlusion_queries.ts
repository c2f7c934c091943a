/**
 * What a test asks of each region of the drawn coarse chunks: whether it shows in so many pixels, or
 * with 0, whether any part of its cells is in front of what the picture shows.
 */
export type MinPixels = number;

/**
 * Most of a picture's coarse parts are hidden once those in front of them are refined, so what shows
 * most is refined first: before the view rests, and then step by step. What is left at the end is
 * refined unless nothing of it can be seen.
 */
const beforeRest = 255;
const atRest: readonly MinPixels[] = [160, 0];

/** What an occlusion query is to find out: which regions of these drawn chunks may be seen. */
export interface OcclusionQuery {
  readonly ids: Uint32Array;
  readonly minPixels: MinPixels;
  /** Of the view and of the picture that it is asked for. */
  readonly view: number;
  readonly picture: number;
}

/** Keeps count of which picture an occlusion query is wanted of, and whether the last answer still holds. */
export class OcclusionQueries {
  #view = 0;
  #picture = 0;
  /** What is to be tested; undefined: occlusion is not asked for. */
  #ids: Uint32Array | undefined;
  #answered: { picture: number; settled: boolean; minPixels: MinPixels } | undefined;
  /** Of `atRest`: all that shows in so many pixels of this view as the one before says is refined. */
  #step = 0;

  /** Something else is looked at: answers to older questions say nothing of it. */
  viewChanged(): void {
    ++this.#view;
    this.#step = 0;
    this.pictureChanged();
  }

  /** The same view shows something else: its test is to be repeated. */
  pictureChanged(): void {
    ++this.#picture;
  }

  /**
   * From now on these chunks are to be tested. `isMoreWanted`: by the last answer, there is something
   * to fetch.
   */
  need(ids: Uint32Array | undefined, isMoreWanted: boolean): void {
    this.#ids = ids;
    if (!isMoreWanted && this.#isAnswered() && this.#step < atRest.length - 1) ++this.#step;
  }

  /** Nothing that can be seen is to be refined: nothing is to be tested, or all of it has been. */
  get done(): boolean {
    if (!this.#ids || this.#ids.length === 0) return true;
    return this.#step === atRest.length - 1 && this.#isAnswered();
  }

  /** The present step's test has been made: as far as it gets while something wanted has failed. */
  get answered(): boolean {
    return !this.#ids || this.#ids.length === 0 || this.#isAnswered();
  }

  /** `settled`: a picture drawn now would not be drawn more exactly when the view rests. */
  query(settled: boolean): OcclusionQuery | undefined {
    if (this.done || !this.#ids) return undefined;
    const isFirst = !settled && this.#step === 0;
    const minPixels = isFirst ? beforeRest : this.#minAtRest;
    const before = this.#answered;
    const isSame =
      before?.picture === this.#picture &&
      before.minPixels <= minPixels &&
      (before.settled || !settled);
    if (isSame) return undefined;
    return { ids: this.#ids, minPixels, view: this.#view, picture: this.#picture };
  }

  /** Takes note of an answer; says whether it is about the present view. */
  take({ view, picture, minPixels }: OcclusionQuery, settled: boolean): boolean {
    this.#answered = { picture, settled, minPixels };
    return view === this.#view;
  }

  get #minAtRest(): MinPixels {
    return atRest[this.#step] ?? 0;
  }

  /** This step's test has been made of the present picture, as it is at rest. */
  #isAnswered(): boolean {
    const before = this.#answered;
    return (
      before?.picture === this.#picture && before.settled && before.minPixels <= this.#minAtRest
    );
  }
}
