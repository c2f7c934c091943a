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

  /** The view that has come to rest last, or that undo or redo has restored. */
  get present(): View | undefined {
    return this.#present?.view;
  }

  /** Adds the view that has come to rest. If it has the key of the present one, it replaces it without a step. */
  rested(key: string, view: View): void {
    const isSame = this.#present?.key === key;
    const before = isSame ? null : this.#present;
    this.#present = { key, view };
    if (isSame) return;
    if (before) this.#past = [...this.#past, before].slice(-most);
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
