import "./layers.css";
import { html, nothing, render, type TemplateResult } from "lit";
import { repeat } from "lit/directives/repeat.js";
import { layersTexts } from "../../texts/layers.ts";
import { chosenTools } from "./chosen_tools.ts";
import { LayerDrag } from "./layer_drag.ts";
import { groupRow, layerRow, type RowActions, rowHeight } from "./layer_row.ts";
import {
  type Drop,
  dropOf,
  found,
  type LayerEntry,
  type ListRow,
  rowsInView,
  rowsOf,
} from "./layer_rows.ts";

/** The data that the section shows. */
export interface LayersSectionState {
  entries: readonly LayerEntry[];
  /** Whether the chosen layer is shown alone. */
  isSolo: boolean;
  /** Notes on the positions of the layers in the world. */
  notes: readonly string[];
}

/** Layers are identified by their keys. */
export interface LayersActions {
  choose(key: number): void;
  show(keys: readonly number[], isVisible: boolean): void;
  solo(key: number): void;
  changeSurface(key: number, change: { colour?: string; opacity?: number }): void;
  change(key: number, change: { name?: string; group?: string }): void;
  drop(key: number, drop: Drop): void;
  remove(key: number): void;
  add(): void;
  /** Saves what is shown as a scene. */
  save(): void;
}

/** Search is offered if there are more layers than this. */
const mostWithoutSearch = 11;
/** The height of the other parts of the panel down to the isovalue, in CSS pixels. */
const restHeight = 560;

/** The number of rows that are visible at a time. Longer lists scroll. */
function mostRows(): number {
  return Math.max(6, Math.min(14, Math.floor((innerHeight - restHeight) / rowHeight)));
}

/**
 * The list of layers in the panel. Draws only the rows in view. Holds the state of the list: search,
 * collapsed groups, the focused row, and the row that is being dragged or renamed.
 */
export class LayersSection {
  readonly element = document.createElement("div");
  readonly #actions: LayersActions;
  readonly #present: () => LayersSectionState;
  #state: LayersSectionState = { entries: [], isSolo: false, notes: [] };
  #query = "";
  readonly #collapsed = new Set<string>();
  #top = 0;
  #renaming: number | null = null;
  /** The layer, or the group, whose row has the focus. */
  #focused: number | string | null = null;
  #announced = "";
  readonly #drag = new LayerDrag({
    changed: () => this.#render(),
    drop: (key, at) => this.#drop(key, at),
  });

  constructor(present: () => LayersSectionState, actions: LayersActions) {
    this.#present = present;
    this.#actions = actions;
    this.element.className = "fields layers";
  }

  /** The layers have changed. */
  refresh(): void {
    this.#state = this.#present();
    this.#render();
  }

  get #found(): readonly LayerEntry[] {
    return found(this.#state.entries, this.#hasSearch ? this.#query : "");
  }

  get #hasSearch(): boolean {
    return this.#state.entries.length > mostWithoutSearch;
  }

  get #rows(): readonly ListRow[] {
    return rowsOf(this.#found, this.#collapsed);
  }

  #render(): void {
    const { entries, isSolo, notes } = this.#state;
    const rows = this.#rows;
    const chosen = entries.find(({ isChosen }) => isChosen);
    const keys = this.#found.map(({ key }) => key);
    render(
      html`<div class="chips layers-all">
          ${this.#hasSearch ? this.#search() : nothing}
          <button type="button" class="chip" @click=${() => this.#actions.show(keys, true)}>
            ${layersTexts.all}
          </button>
          <button type="button" class="chip" @click=${() => this.#actions.show(keys, false)}>
            ${layersTexts.none}
          </button>
          <button type="button" class="chip" @click=${() => this.#actions.add()}>
            ${layersTexts.add}
          </button>
          <button type="button" class="chip" title=${layersTexts.saveTitle} @click=${() => this.#actions.save()}>
            ${layersTexts.save}
          </button>
        </div>
        ${rows.length === 0 ? html`<p class="quiet">${layersTexts.noMatch}</p>` : this.#list(rows)}
        ${chosen ? chosenTools(chosen, isSolo, this.#chosenActions(chosen)) : nothing}
        ${notes.map((note) => html`<p class="layers-note" role="note">${note}</p>`)}
        <p class="visually-hidden" id="layers-keys">${layersTexts.keys}</p>
        <p class="visually-hidden" role="status">${this.#announced}</p>`,
      this.element,
    );
  }

  #search(): TemplateResult {
    return html`<input
      class="small-input layers-search"
      type="search"
      placeholder=${layersTexts.search}
      aria-label=${layersTexts.searchLabel}
      .value=${this.#query}
      @input=${(event: Event) => {
        this.#query = (event.currentTarget as HTMLInputElement).value;
        this.#top = 0;
        this.#render();
        this.element.querySelector(".layer-list")?.scrollTo(0, 0);
      }}
    />`;
  }

  #list(rows: readonly ListRow[]): TemplateResult {
    const current = this.#currentRow(rows);
    const height = Math.min(rows.length, mostRows()) * rowHeight;
    const drawn = rowsInView(rows.length, { top: this.#top, height, rowHeight }, [current]);
    const line = this.#drag.at;
    return html`<div
      class="layer-list"
      style=${`height:${height}px`}
      @scroll=${(event: Event) => {
        this.#top = (event.currentTarget as HTMLElement).scrollTop;
        this.#render();
      }}
    >
      <ul
        aria-label=${layersTexts.list}
        style=${`height:${rows.length * rowHeight}px`}
        @keydown=${(event: KeyboardEvent) => this.#key(event)}
      >
        ${repeat(
          drawn,
          (i) => idOf(rows[i]),
          (i) => this.#row(rows, i, i === current),
        )}
        ${line === null ? nothing : html`<li class="layer-line" role="presentation" style=${`top:${line * rowHeight - 1}px`}></li>`}
      </ul>
    </div>`;
  }

  /** The index of the row that the Tab key reaches. */
  #currentRow(rows: readonly ListRow[]): number {
    const focused = rows.findIndex((row) => idOf(row) === this.#focused);
    if (focused >= 0) return focused;
    const chosen = rows.findIndex((row) => row.kind === "layer" && row.entry.isChosen);
    return Math.max(0, chosen);
  }

  #row(rows: readonly ListRow[], index: number, isCurrent: boolean): TemplateResult | undefined {
    const row = rows[index];
    if (!row) return undefined;
    const position = { index, count: rows.length, isCurrent };
    if (row.kind === "group") return groupRow(row, position, this.#rowActions);
    const { key } = row.entry;
    const isDragged = this.#drag.key === key;
    const isRenaming = this.#renaming === key;
    return layerRow(row.entry, { ...position, isDragged, isRenaming }, this.#rowActions);
  }

  readonly #rowActions: RowActions = {
    choose: (key) => this.#actions.choose(key),
    show: (keys, isVisible) => this.#actions.show(keys, isVisible),
    changeSurface: (key, change) => this.#actions.changeSurface(key, change),
    focused: (id) => {
      if (this.#focused === id) return;
      this.#focused = id;
      this.#render();
    },
    collapse: (group) => {
      if (!this.#collapsed.delete(group)) this.#collapsed.add(group);
      this.#render();
    },
    grip: (event, key) => {
      // Layers in the results of a search may not be adjacent in the list, so they cannot be dragged.
      if (this.#query === "" || !this.#hasSearch) this.#drag.start(event, key, this.#rows.length);
    },
    beginName: (key) => this.#rename(key),
    endName: (key, name) => {
      this.#renaming = null;
      if (name !== undefined) this.#actions.change(key, { name: name.trim() });
      this.#render();
      this.#focusRow(key);
    },
  };

  #chosenActions({ key }: LayerEntry) {
    return {
      solo: () => this.#actions.solo(key),
      rename: () => this.#rename(key),
      move: (by: -1 | 1) => this.#step(key, by),
      remove: () => this.#remove(key),
      group: (group: string) => this.#actions.change(key, { group: group.trim() }),
    };
  }

  #key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (!target.matches(".layer-name, .layer-group-name")) return;
    const rows = this.#rows;
    const index = rows.findIndex((row) => idOf(row) === this.#focused);
    const row = rows[index];
    if (!row || event.ctrlKey || event.metaKey) return;
    const by = event.key === "ArrowUp" ? -1 : event.key === "ArrowDown" ? 1 : 0;
    const key = row.kind === "layer" ? row.entry.key : undefined;
    if (by !== 0 && !event.altKey) this.#focusRow(idOf(rows[index + by]));
    else if (event.key === "Home") this.#focusRow(idOf(rows[0]));
    else if (event.key === "End") this.#focusRow(idOf(rows.at(-1)));
    else if (by !== 0 && key !== undefined) this.#step(key, by);
    else if (event.key === "F2" && key !== undefined) this.#rename(key);
    else if (event.key === "Delete" && key !== undefined) this.#remove(key);
    else return;
    event.preventDefault();
  }

  /** Draws the row of a layer or a group, scrolls to it and focuses it. */
  #focusRow(id: number | string | undefined): void {
    if (id === undefined) return;
    this.#focused = id;
    this.#render();
    const button = this.element.querySelector<HTMLElement>(
      `[data-row="${CSS.escape(String(id))}"] .layer-name, [data-row="${CSS.escape(String(id))}"] .layer-group-name`,
    );
    button?.focus();
  }

  #rename(key: number): void {
    this.#renaming = key;
    this.#focused = key;
    this.#render();
    this.element.querySelector<HTMLInputElement>(".layer-rename")?.select();
  }

  /** Moves a layer by one row. */
  #step(key: number, by: -1 | 1): void {
    const at = this.#rows.findIndex((row) => row.kind === "layer" && row.entry.key === key);
    const hadFocus = this.#focused === key && this.element.querySelector(".layer-name:focus");
    if (at >= 0) this.#drop(key, by < 0 ? at - 1 : at + 2);
    if (hadFocus) this.#focusRow(key);
  }

  #drop(key: number, at: number): void {
    const rows = this.#rows;
    if (at < 0 || at > rows.length) return;
    const drop = dropOf(rows, key, at);
    if (!drop) return;
    this.#actions.drop(key, drop);
    this.#state = this.#present();
    const after = this.#state.entries.filter(({ isOpening }) => !isOpening);
    const index = after.findIndex((entry) => entry.key === key);
    const title = after[index]?.title ?? "";
    this.#announced = layersTexts.moved(title, index + 1, after.length);
    this.#render();
  }

  #remove(key: number): void {
    const rows = this.#rows;
    const at = rows.findIndex((row) => row.kind === "layer" && row.entry.key === key);
    const entry = this.#state.entries.find((each) => each.key === key);
    if (!entry || entry.isFirst) return;
    const hadFocus = this.element.contains(document.activeElement);
    this.#actions.remove(key);
    this.#announced = layersTexts.removed(entry.title);
    this.refresh();
    if (hadFocus) this.#focusRow(idOf(this.#rows[Math.min(at, this.#rows.length - 1)]));
  }
}

/** The key of a layer, or the name of a group. */
function idOf(row: ListRow | undefined): number | string | undefined {
  return row?.kind === "group" ? `group ${row.group}` : row?.entry.key;
}
