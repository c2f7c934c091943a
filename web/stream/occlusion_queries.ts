/**
 * A region of a drawn coarse chunk counts as visible if it covers at least this many pixels; with 0,
 * if any part of its cells is in front of the picture.
 */
export type MinPixels = number;

/**
 * Most coarse regions are occluded once those in front of them are refined. So regions with many
 * visible pixels are refined first. Then every region that may be visible is refined. A fast picture,
 * which is drawn anyway, is tested first, so that the resting picture, which may take a second, is
 * drawn when everything is resident. The resting picture is tested last, because only its splats stay
 * inside their cells.
 */
const steps: readonly { minPixels: MinPixels; atRest: boolean }[] = [
  { minPixels: 255, atRest: false },
  { minPixels: 0, atRest: false },
  { minPixels: 0, atRest: true },
];
const lastStep = steps.length - 1;

/** Finds which regions of these drawn chunks may be visible. */
export interface OcclusionQuery {
  readonly ids: Uint32Array;
  readonly minPixels: MinPixels;
  /** Numbers of the camera view and of the picture that the query is for. */
  readonly view: number;
  readonly picture: number;
}

/** The part of a selection that concerns the next query. */
export interface OcclusionNeeds {
  /** The chunks to test; undefined if occlusion queries are not used. */
  ids: Uint32Array | undefined;
  /** Chunks or pages that earlier results require are being fetched. Damaged ones do not count. */
  isLoading: boolean;
  /** The present picture must be tested to find the chunks to fetch. */
  isUndecided: boolean;
  /** Coarse chunks are being fetched whose test decides more than a test of the present picture. */
  isTooCoarse: boolean;
}

/** Decides which picture needs an occlusion query, and whether the last answer is still valid. */
export class OcclusionQueries {
  #view = 0;
  #picture = 0;
  #needs: OcclusionNeeds | undefined;
  #answered: { picture: number; settled: boolean; minPixels: MinPixels } | undefined;
  /** Index into `steps`. All regions found visible by earlier steps are refined. */
  #step = 0;
  /** A picture of this view has been tested at the present step. */
  #isStepAnswered = false;

  /** The camera view has changed: answers to earlier queries are not valid for it. */
  viewChanged(): void {
    ++this.#view;
    this.#step = 0;
    this.#isStepAnswered = false;
    this.pictureChanged();
  }

  /** The same camera view has another picture: the last step needs another query. */
  pictureChanged(): void {
    ++this.#picture;
  }

  /** Sets what the present selection needs. */
  need(needs: OcclusionNeeds): void {
    this.#needs = needs;
    while (
      this.#step < lastStep &&
      (this.#isStepAnswered || this.#isAnswered()) &&
      !needs.isLoading &&
      !needs.isUndecided
    ) {
      ++this.#step;
      this.#isStepAnswered = false;
    }
  }

  /**
   * Whether everything visible is refined: there is nothing to test, or the last step has its result.
   */
  get done(): boolean {
    return this.#ids.length === 0 || (this.#step === lastStep && this.#isAnswered());
  }

  /** Whether only the test of the resting picture is missing, so that it should be drawn now. */
  get needsRest(): boolean {
    return !this.done && this.#step === lastStep && this.#needs?.isLoading === false;
  }

  /** `settled`: a picture drawn now would be the same at rest. */
  query(settled: boolean): OcclusionQuery | undefined {
    if (this.done || !this.#needs || this.#needs.isTooCoarse) return undefined;
    const { minPixels, atRest } = this.#present;
    if (atRest && !settled) return undefined;
    // Chunks that are being fetched will occlude regions that are visible in the present picture.
    if (this.#step > 0 && this.#needs.isLoading) return undefined;
    if (this.#isAnswered()) return undefined;
    return { ids: this.#ids, minPixels, view: this.#view, picture: this.#picture };
  }

  /** Records a result. Returns whether it is valid for the present camera view. */
  record({ view, picture, minPixels }: OcclusionQuery, settled: boolean): boolean {
    const isValid = view === this.#view;
    if (!isValid) return false;
    this.#answered = { picture, settled, minPixels };
    if (minPixels <= this.#present.minPixels) this.#isStepAnswered = true;
    return true;
  }

  get #ids(): Uint32Array {
    return this.#needs?.ids ?? noIds;
  }

  get #present(): { minPixels: MinPixels; atRest: boolean } {
    return steps[this.#step] ?? { minPixels: 0, atRest: true };
  }

  /** Whether this step has a result for the present picture. */
  #isAnswered(): boolean {
    const before = this.#answered;
    const { minPixels, atRest } = this.#present;
    return (
      before?.picture === this.#picture &&
      before.minPixels <= minPixels &&
      (before.settled || !atRest)
    );
  }
}

const noIds = new Uint32Array();
