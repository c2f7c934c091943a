import { rowHeight } from "./layer_row.ts";

export interface LayerDragHost {
  /** `key` or `at` has changed. */
  changed(): void;
  drop(key: number, at: number): void;
}

/** Dragging within this distance from the upper or lower edge of the list scrolls it (CSS pixels). */
const edge = 20;
/** The distance scrolled per pointer event (CSS pixels). */
const scrollStep = 10;

/** Moves a layer in the list by dragging its handle, with a mouse, a pen or a finger. */
export class LayerDrag {
  readonly #host: LayerDragHost;
  #key: number | null = null;
  #at: number | null = null;

  constructor(host: LayerDragHost) {
    this.#host = host;
  }

  /** The layer that is dragged. */
  get key(): number | null {
    return this.#key;
  }

  /** The index of the row before which it would be dropped. */
  get at(): number | null {
    return this.#at;
  }

  /** `rows`: the number of rows in the list. */
  start(event: PointerEvent, key: number, rows: number): void {
    const list = (event.currentTarget as HTMLElement).closest<HTMLElement>(".layer-list");
    if (!list || event.button !== 0) return;
    event.preventDefault(); // no selection of text
    list.setPointerCapture(event.pointerId);
    const ending = new AbortController();
    const { signal } = ending;
    const end = (isDropped: boolean) => {
      ending.abort();
      const at = this.#at;
      this.#key = null;
      this.#at = null;
      this.#host.changed();
      if (isDropped && at !== null) this.#host.drop(key, at);
    };
    this.#key = key;
    list.addEventListener("pointermove", (move) => this.#move(move, list, rows), { signal });
    list.addEventListener("pointerup", () => end(true), { signal });
    list.addEventListener("pointercancel", () => end(false), { signal });
    window.addEventListener(
      "keydown",
      (pressed) => {
        if (pressed.key === "Escape") end(false);
      },
      { signal },
    );
    this.#host.changed();
  }

  #move({ clientY }: PointerEvent, list: HTMLElement, rows: number): void {
    const { top, bottom } = list.getBoundingClientRect();
    if (clientY < top + edge) list.scrollTop -= scrollStep;
    if (clientY > bottom - edge) list.scrollTop += scrollStep;
    const at = Math.round((clientY - top + list.scrollTop) / rowHeight);
    this.#at = Math.max(0, Math.min(rows, at));
    this.#host.changed();
  }
}
