import { html, nothing, type TemplateResult } from "lit";
import { live } from "lit/directives/live.js";
import { layersTexts } from "../../texts/layers.ts";
import { icon } from "../shell/icons.ts";
import type { GroupRow, LayerEntry } from "./layer_rows.ts";

/** The height of a row in CSS pixels, as in layers.css. */
export const rowHeight = 34;

/** The position of a row in the list. */
export interface RowPosition {
  index: number;
  count: number;
  /** Whether the Tab key reaches its controls. */
  isCurrent: boolean;
}

export interface RowActions {
  choose(key: number): void;
  show(keys: readonly number[], isVisible: boolean): void;
  changeSurface(key: number, change: { colour?: string; opacity?: number }): void;
  /** A control of the row has got the focus. `id`: the key of a layer, or "group NAME". */
  focused(id: number | string): void;
  collapse(group: string): void;
  /** The pointer is pressed on the handle of a layer. */
  grip(event: PointerEvent, key: number): void;
  beginName(key: number): void;
  /** undefined: the name stays. */
  endName(key: number, name: string | undefined): void;
}

const tab = ({ isCurrent }: RowPosition) => (isCurrent ? "0" : "-1");
const top = ({ index }: RowPosition) => `top:${index * rowHeight}px`;

function eye(
  label: string,
  isVisible: boolean | "mixed",
  position: RowPosition,
  toggle: () => void,
): TemplateResult {
  return html`<button
    type="button"
    class="layer-eye"
    tabindex=${tab(position)}
    aria-pressed=${String(isVisible)}
    aria-label=${label}
    title=${label}
    @click=${toggle}
  >
    ${icon(isVisible === false ? "hidden" : "shown")}
  </button>`;
}

export function groupRow(
  row: GroupRow,
  position: RowPosition,
  actions: RowActions,
): TemplateResult {
  const { group, keys, visible, isCollapsed } = row;
  const id = `group ${group}`;
  const isVisible = visible === keys.length ? true : visible > 0 ? "mixed" : false;
  return html`<li
    class="layer-row layer-group"
    data-row=${id}
    style=${top(position)}
    aria-setsize=${position.count}
    aria-posinset=${position.index + 1}
    @focusin=${() => actions.focused(id)}
  >
    <button
      type="button"
      class="layer-group-name"
      tabindex=${tab(position)}
      aria-expanded=${String(!isCollapsed)}
      aria-label=${layersTexts.group(group, keys.length)}
      title=${group}
      @click=${() => actions.collapse(group)}
    >
      ${icon(isCollapsed ? "open" : "down")}<span class="layer-title">${group}</span
      ><span class="quiet">${keys.length}</span>
    </button>
    ${eye(layersTexts.showGroup(group), isVisible, position, () => actions.show(keys, isVisible !== true))}
  </li>`;
}

export function layerRow(
  entry: LayerEntry,
  position: RowPosition & { isDragged: boolean; isRenaming: boolean },
  actions: RowActions,
): TemplateResult {
  const { key, title, group, isChosen, isOpening, colour, opacity } = entry;
  const classes = [
    "layer-row",
    isChosen && "chosen",
    group && "in-group",
    position.isDragged && "dragged",
    !entry.visible && "is-hidden",
  ];
  return html`<li
    class=${classes.filter(Boolean).join(" ")}
    data-row=${key}
    style=${top(position)}
    aria-setsize=${position.count}
    aria-posinset=${position.index + 1}
    @focusin=${() => actions.focused(key)}
  >
    <span
      class="layer-grip"
      title=${layersTexts.move}
      @pointerdown=${(event: PointerEvent) => actions.grip(event, key)}
      >${icon("grip")}</span
    >
    ${
      colour === undefined
        ? html`<span class="swatch unknown"></span>`
        : html`<input
            type="color"
            class="swatch"
            tabindex=${tab(position)}
            aria-label=${layersTexts.colourOf(title)}
            .value=${live(colour)}
            @input=${(event: Event) =>
              actions.changeSurface(key, { colour: (event.target as HTMLInputElement).value })}
          />`
    }
    ${position.isRenaming ? nameField(entry, actions) : nameButton(entry, position, actions)}
    ${
      opacity === undefined || isOpening
        ? html`<span class="quiet layer-state">${isOpening ? layersTexts.opening : nothing}</span>`
        : html`<input
            type="range"
            class="layer-opacity"
            tabindex=${tab(position)}
            min="0.05"
            max="1"
            step="0.05"
            aria-label=${layersTexts.opacityOf(title)}
            aria-valuetext=${`${Math.round(100 * opacity)} %`}
            title=${layersTexts.opacityOf(title)}
            .valueAsNumber=${live(opacity)}
            @input=${(event: Event) =>
              actions.changeSurface(key, {
                opacity: (event.target as HTMLInputElement).valueAsNumber,
              })}
          />`
    }
    ${eye(layersTexts.show(title), entry.visible, position, () => actions.show([key], !entry.visible))}
  </li>`;
}

function nameButton(
  { key, title, isChosen, problem }: LayerEntry,
  position: RowPosition,
  actions: RowActions,
): TemplateResult {
  return html`<button
    type="button"
    class="layer-name"
    tabindex=${tab(position)}
    aria-pressed=${String(isChosen)}
    aria-describedby="layers-keys"
    title=${problem ?? title}
    @click=${() => actions.choose(key)}
    @dblclick=${() => actions.beginName(key)}
  >
    ${problem ? icon("alert") : nothing}<span class="layer-title">${title}</span
    >${problem ? html`<span class="visually-hidden">: ${problem}</span>` : nothing}
  </button>`;
}

function nameField({ key, title }: LayerEntry, actions: RowActions): TemplateResult {
  let isEnded = false;
  const end = (name: string | undefined) => {
    if (isEnded) return; // a key that ends the editing also removes the focus
    isEnded = true;
    actions.endName(key, name);
  };
  return html`<input
    class="small-input layer-rename"
    type="text"
    maxlength="200"
    aria-label=${layersTexts.nameOf(title)}
    .value=${title}
    @keydown=${(event: KeyboardEvent) => {
      if (event.key !== "Enter" && event.key !== "Escape") return;
      event.preventDefault();
      const { value } = event.currentTarget as HTMLInputElement;
      end(event.key === "Enter" && value !== title ? value : undefined);
    }}
    @blur=${(event: Event) => {
      const { value } = event.currentTarget as HTMLInputElement;
      end(value === title ? undefined : value);
    }}
  />`;
}
