/**
 * A region of a drawn coarse chunk counts as visible if it covers at least this many pixels; with 0,
 * if any part of its cells is in front of the picture.
 */
export type MinPixels = number;

/**
 * Most coarse regions are occluded once those in front of them are refined. So regions with many
 * visible pixels are refined first: one threshold before the view is at rest, then a falling sequence.
 * With the last threshold, every region that may be visible is refined.
 */
const beforeRest = 255;
const atRest: readonly MinPixels[] = [160, 0];

/** Finds which regions of these drawn chunks may be visible. */
export interface OcclusionQuery {
  readonly ids: Uint32Array;
  readonly minPixels: MinPixels;
  /** Numbers of the camera view and of the picture that the query is for. */
  readonly view: number;
  readonly picture: number;
}

/** Decides which picture needs an occlusion query, and whether the last answer is still valid. */
export class OcclusionQueries {
  #view = 0;
  #picture = 0;
  /** The chunks to test; undefined if occlusion queries are not used. */
  #ids: Uint32Array | undefined;
  #answered: { picture: number; settled: boolean; minPixels: MinPixels } | undefined;
  /** Index into `atRest`. Everything visible by the thresholds before it is refined. */
  #step = 0;

  /** The camera view has changed: answers to earlier queries are not valid for it. */
  viewChanged(): void {
    ++this.#view;
    this.#step = 0;
    this.pictureChanged();
  }

  /** The same camera view has another picture: the query is repeated. */
  pictureChanged(): void {
    ++this.#picture;
  }

  /** Sets the chunks to test. `isMoreNeeded`: by the last answer, there is something to fetch. */
  need(ids: Uint32Array | undefined, isMoreNeeded: boolean): void {
    this.#ids = ids;
    if (!isMoreNeeded && this.#isAnswered() && this.#step < atRest.length - 1) ++this.#step;
  }

  /** Everything visible is refined: there is nothing to test, or the last step has its answer. */
  get done(): boolean {
    if (!this.#ids || this.#ids.length === 0) return true;
    return this.#step === atRest.length - 1 && this.#isAnswered();
  }

  /** The present step has its answer. While a needed chunk has failed, there is no further step. */
  get answered(): boolean {
    return !this.#ids || this.#ids.length === 0 || this.#isAnswered();
  }

  /** `settled`: a picture drawn now would be the same at rest. */
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

  /** Records an answer. Returns whether it is valid for the present camera view. */
  record({ view, picture, minPixels }: OcclusionQuery, settled: boolean): boolean {
    this.#answered = { picture, settled, minPixels };
    return view === this.#view;
  }

  get #minAtRest(): MinPixels {
    return atRest[this.#step] ?? 0;
  }

  /** Whether this step was answered for the present picture at rest. */
  #isAnswered(): boolean {
    const before = this.#answered;
    return (
      before?.picture === this.#picture && before.settled && before.minPixels <= this.#minAtRest
    );
  }
}
