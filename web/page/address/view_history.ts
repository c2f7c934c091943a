/** Maximum number of views that can be undone. */
const most = 100;

interface Entry<View> {
  key: string;
  view: View;
}

/** The views at which the page came to rest, for undo and redo. Views with the same key are the same. */
export class ViewHistory<View> {
  #past: readonly Entry<View>[] = [];
  #present: Entry<View> | null = null;
  #future: readonly Entry<View>[] = [];

  get canUndo(): boolean {
    return this.#past.length > 0;
  }

  get canRedo(): boolean {
    return this.#future.length > 0;
  }

  /** Adds the view that has come to rest. */
  rested(key: string, view: View): void {
    if (this.#present?.key === key) return;
    if (this.#present) this.#past = [...this.#past, this.#present].slice(-most);
    this.#present = { key, view };
    this.#future = [];
  }

  /** Forgets all views: there is nothing to undo. */
  forget(): void {
    this.#past = [];
    this.#present = null;
    this.#future = [];
  }

  /** The next view that comes to rest replaces the present one, without a step. */
  replacePresent(): void {
    this.#present = null;
  }

  /** Makes the previous view the present one, and returns it. */
  undo(): View | undefined {
    const before = this.#past.at(-1);
    if (!before || !this.#present) return undefined;
    this.#past = this.#past.slice(0, -1);
    this.#future = [this.#present, ...this.#future];
    this.#present = before;
    return before.view;
  }

  redo(): View | undefined {
    const [next, ...later] = this.#future;
    if (!next || !this.#present) return undefined;
    this.#past = [...this.#past, this.#present];
    this.#present = next;
    this.#future = later;
    return next.view;
  }
}
