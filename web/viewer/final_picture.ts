/** Marks the browser's timeline when the picture at rest of a view is finished, and nothing will replace it. */
export class FinalPicture {
  /** The number of the view, and of its chunks to draw. */
  #view = 0;
  #isFinished = false;
  #isStreaming = false;
  #isMarked = false;

  /** The view, or the set of chunks to draw, has changed. */
  changed(): void {
    ++this.#view;
    this.#isFinished = false;
    this.#isMarked = false;
  }

  get view(): number {
    return this.#view;
  }

  /** Whether more data will come for the present view. */
  streams(isStreaming: boolean): void {
    this.#isStreaming = isStreaming;
    this.#mark();
  }

  /** The GPU has finished a picture at rest of this view; undefined: not at rest. */
  finished(view: number | undefined): void {
    if (view !== this.#view) return;
    this.#isFinished = true;
    this.#mark();
  }

  #mark(): void {
    if (!this.#isFinished || this.#isStreaming || this.#isMarked) return;
    this.#isMarked = true;
    performance.mark?.("isosplat:final");
  }
}
