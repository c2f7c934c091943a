/** What a sight query is to find out: which regions of these drawn chunks may be seen. */
export interface SightQuery {
  readonly ids: Uint32Array;
  /** Of the view and of the picture that it is asked for. */
  readonly view: number;
  readonly picture: number;
}

/** Keeps count of which picture a sight query is wanted of, and whether the last answer still holds. */
export class SightQueries {
  #view = 0;
  #picture = 0;
  /** What is to be tested; undefined: occlusion is not asked for. */
  #ids: Uint32Array | undefined;
  #answered = { picture: -1, settled: false };

  /** Something else is looked at: answers to older questions say nothing of it. */
  viewChanged(): void {
    ++this.#view;
    this.pictureChanged();
  }

  /** The same view shows something else: its test is to be repeated. */
  pictureChanged(): void {
    ++this.#picture;
  }

  /** From now on these chunks are to be tested. */
  need(ids: Uint32Array | undefined): void {
    this.#ids = ids;
  }

  /** The picture hides what it hides: nothing is to be tested, or all of it has been. */
  get done(): boolean {
    if (!this.#ids || this.#ids.length === 0) return true;
    return this.#answered.picture === this.#picture && this.#answered.settled;
  }

  /** `settled`: a picture drawn now would not be drawn more exactly when the view rests. */
  query(settled: boolean): SightQuery | undefined {
    if (this.done || !this.#ids) return undefined;
    if (this.#answered.picture === this.#picture && !settled) return undefined;
    return { ids: this.#ids, view: this.#view, picture: this.#picture };
  }

  /** Takes note of an answer; says whether it is about the present view. */
  answered(query: SightQuery, settled: boolean): boolean {
    this.#answered = { picture: query.picture, settled };
    return query.view === this.#view;
  }
}
