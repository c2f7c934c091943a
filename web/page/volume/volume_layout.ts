import { html, nothing, type TemplateResult } from "lit";
import { guard } from "lit/directives/guard.js";
import type { StoreInfo } from "../../core/types.ts";
import type { Offer } from "../../stream/faults.ts";
import { pageTexts } from "../../texts/page.ts";
import { panelTexts } from "../../texts/panel.ts";
import type { Legend } from "../../viewer/types.ts";
import { appearanceSection } from "../panel/appearance_section.ts";
import { clippingSection } from "../panel/clipping_section.ts";
import { isovalueSection } from "../panel/isovalue_section.ts";
import { legendPart } from "../panel/legend.ts";
import { lightSection } from "../panel/light_section.ts";
import type { PanelActions, PanelState } from "../panel/panel_state.ts";
import { surfacesSection } from "../panel/surfaces_section.ts";
import { viewSection } from "../panel/view_section.ts";
import { volumeSection } from "../panel/volume_section.ts";
import { brand, iconButton, type ListedName, problemCard, themeButton } from "../shell/chrome.ts";
import { formatDims, formatType } from "../shell/format.ts";
import { icon } from "../shell/icons.ts";
import type { Problem } from "../shell/problems.ts";
import { theme } from "../shell/theme.ts";
import type { ToastMessage } from "../shell/toast.ts";
import { canShare } from "./copy_link.ts";

/** A message beside the picture, which stays visible. */
export interface Banner {
  text: string;
  /** The expected and the found value, for a report. */
  detail?: string;
  /** Whether the page will retry soon without further calls. */
  isWaiting: boolean;
  offers: readonly Offer[];
}

export interface LayoutState {
  title: string;
  /** The description of a provisional store. */
  provisional: string | undefined;
  /** Buttons that are loaded later. */
  tools: HTMLElement | null;
  /** Null until the volume is open, since there is nothing to control before. */
  panel: PanelState | null;
  background: string;
  problem: Problem | null;
  /** The volumes or scenes that the visitor can open instead. */
  others: readonly ListedName[];
  legend: Legend | null;
  banner: Banner | null;
  toast: ToastMessage | null;
  /** For screen readers: what a key has changed. */
  announced: string;
  /** Whether there is no picture yet, but the volume is loading. */
  isOpening: boolean;
  isSheetOpen: boolean;
  isPanelHidden: boolean;
  canvas: HTMLElement;
  /** The overlay over the canvas; null until it has loaded. */
  overlay: HTMLElement | null;
  /** The clip box and its handles over the canvas; null unless they are shown. */
  clipHandles: HTMLElement | null;
  /** The marks of measurements over the canvas, and their section; null until loaded. */
  measure: { element: HTMLElement; section: TemplateResult } | null;
  /** The list of layers; null until loaded. */
  layersSection: HTMLElement | null;
  /** Whether there are several layers, so that the list is shown. */
  isOfSeveral: boolean;
  /** The layer on which isovalue and surfaces act, if there are several. `info`: null until it has been opened. */
  chosen: { title: string; info: StoreInfo | null } | null;
  /** The section of slices; null until loaded. */
  slicesSection: ((state: PanelState, actions: PanelActions) => TemplateResult) | null;
  /** The bar below the picture; null without steps. */
  timeBar: HTMLElement | null;
  status: HTMLElement;
}

export interface LayoutActions extends PanelActions {
  retry(): void;
  reset(): void;
  savePicture(): void;
  copyLink(): void;
  /** Offers the link to other programs of this device. */
  shareLink(): void;
  toggleSheet(): void;
  /** Loads the measurements at their first use. */
  loadMeasure(): void;
  /** Loads the list of layers at its first use. */
  loadLayers(): void;
  /** Shows the chosen layer, which is hidden. */
  showChosen(): void;
  /** Loads the section of slices at its first use. */
  loadSlices(): void;
  /** Shows keys and gestures. */
  help(): void;
}

/** The page of one volume: bar, picture with overlays, and panel. */
export function volumeLayout(state: LayoutState, actions: LayoutActions): TemplateResult {
  const { panel } = state;
  const isPanelHidden = state.isPanelHidden || (state.problem !== null && !panel);
  const classes = `volume${state.isSheetOpen ? " sheet-open" : ""}${
    isPanelHidden ? " panel-hidden" : ""
  }`;
  return html`<div class=${classes}>
    ${guard([state.title, panel?.info, panel?.canUndo, state.tools, theme()], () => bar(state, actions))}
    <main class="stage" style=${`background:${state.background}`}>
      ${state.canvas} ${state.problem ? nothing : state.overlay} ${state.problem ? nothing : state.measure?.element} ${state.problem ? nothing : state.clipHandles} ${state.banner ? bannerPart(state.banner, actions) : nothing}
      ${cover(state, actions)}
      ${state.provisional ? html`<p class="provisional">${state.provisional}</p>` : nothing}
      ${
        state.toast
          ? html`<div class="toast" role="status">${icon(state.toast.icon)}${state.toast.text}</div>`
          : nothing
      }
      ${state.legend && !state.problem ? legendPart(state.legend, panel?.info.metadata.units) : nothing}
      ${state.status}
      <div class="visually-hidden announced" role="status">${state.announced}</div>
    </main>
    ${state.timeBar}
    ${
      panel
        ? panelPart(panel, state, actions)
        : html`<aside class="panel" aria-hidden="true"></aside>`
    }
  </div>`;
}

function bar({ title, panel, tools }: LayoutState, actions: LayoutActions): TemplateResult {
  return html`<header class="bar">
    ${brand()}
    <h1 class="volume-title">
      <span class="volume-name">${title}</span>
      ${panel ? html`<span class="quiet volume-facts">${facts(panel.info)}</span>` : nothing}
    </h1>
    <span class="bar-space"></span>${tools}
    ${iconButton({
      icon: "undo",
      label: panelTexts.undoTitle,
      action: actions.undo,
      isDisabled: !panel?.canUndo,
    })}
    ${iconButton({ icon: "reset", label: pageTexts.reset, action: actions.reset })}
    ${iconButton({ icon: "camera", label: pageTexts.savePicture, action: actions.savePicture })}
    ${iconButton({
      icon: "link",
      label: pageTexts.copyLink,
      action: actions.copyLink,
      isMinor: canShare, // what shares a link can copy it as well
    })}
    ${canShare ? iconButton({ icon: "share", label: pageTexts.shareLink, action: actions.shareLink }) : nothing}
    ${iconButton({ icon: "help", label: pageTexts.keys, action: actions.help })}
    ${themeButton(true)}
  </header>`;
}

/** Covers the canvas while there is no picture. */
function cover(state: LayoutState, actions: LayoutActions): TemplateResult | typeof nothing {
  if (state.problem) {
    return html`<div class="cover">
      ${problemCard(state.problem, { retry: actions.retry, others: state.others })}
    </div>`;
  }
  if (!state.isOpening) return nothing;
  return html`<div class="opening" aria-hidden="true"><wa-spinner></wa-spinner></div>`;
}

function bannerPart(banner: Banner, actions: LayoutActions): TemplateResult {
  const { text, detail, isWaiting, offers } = banner;
  return html`<div class="banner" role="status">
    ${isWaiting ? html`<wa-spinner></wa-spinner>` : icon("alert")}
    <div>
      ${text}
      ${
        detail
          ? html`<details class="banner-detail">
              <summary>${pageTexts.details}</summary>
              <code>${detail}</code>
            </details>`
          : nothing
      }
    </div>
    ${
      offers.includes("again")
        ? html`<wa-button size="s" appearance="outlined" @click=${actions.retry}
            >${pageTexts.again}</wa-button
          >`
        : nothing
    }
    ${
      offers.includes("reload")
        ? html`<wa-button size="s" appearance="outlined" @click=${() => location.reload()}
            >${pageTexts.loadAnew}</wa-button
          >`
        : nothing
    }
  </div>`;
}

function panelPart(
  state: PanelState,
  { isSheetOpen, measure, slicesSection, layersSection, isOfSeveral, chosen }: LayoutState,
  actions: LayoutActions,
): TemplateResult {
  const info = chosen ? chosen.info : state.info;
  const ofChosen = info && { ...state, info, title: chosen?.title };
  // If there are several layers, the list comes first, since the sections after it refer to the chosen layer.
  const layersPart = html`<wa-details class="section layers-section" appearance="plain" ?open=${isOfSeveral} summary=${panelTexts.layers} @wa-show=${actions.loadLayers}>
    ${layersSection}
  </wa-details>`;
  return html`<aside class="panel" aria-label=${pageTexts.controls} @wa-after-show=${showWhole}>
    <button
      class="sheet-handle"
      type="button"
      aria-expanded=${isSheetOpen}
      aria-controls="more-controls"
      @click=${actions.toggleSheet}
    >
      <span class="visually-hidden">${isSheetOpen ? pageTexts.fewer : pageTexts.more}</span>
      ${icon(isSheetOpen ? "down" : "up")}
    </button>
    ${isOfSeveral ? layersPart : nothing}
    ${ofChosen ? isovalueSection(ofChosen, actions) : hiddenPart(chosen?.title ?? "", actions)}
    <div class="more" id="more-controls">
      ${isOfSeveral ? nothing : layersPart}
      ${ofChosen ? surfacesSection(ofChosen, actions) : nothing}
      <wa-details class="section" appearance="plain" summary=${panelTexts.measure} @wa-show=${actions.loadMeasure}>
        ${measure?.section}
      </wa-details>
      ${guard([state.clip, state.info], () => clippingSection(state, actions))}
      <wa-details class="section" appearance="plain" summary=${panelTexts.slices} @wa-show=${actions.loadSlices}>
        ${guard([state.slices, state.info, state.look, slicesSection], () => slicesSection?.(state, actions))}
      </wa-details>
      ${guard([state.look, state.isThemeBackground, state.info, state.fieldBins, state.hasLabels], () => appearanceSection(state, actions))}
      ${guard([state.look], () => lightSection(state, actions))}
      ${guard([state.show, state.info, state.projection, state.canUndo, state.canRedo], () => viewSection(state, actions))}
      ${ofChosen ? guard([info, state.mayEnterSpacing], () => volumeSection(ofChosen, state.mayEnterSpacing ? actions : undefined)) : nothing}
    </div>
  </aside>`;
}

/** Scrolls a section that was opened into view, as far as it fits. */
function showWhole({ target }: Event): void {
  const section = target as HTMLElement;
  const show = () => section.scrollIntoView({ block: "nearest", behavior: "smooth" });
  show();
  if (section.childElementCount > 0) return;
  // Its contents are being loaded.
  const { offsetHeight } = section;
  const growth = new ResizeObserver(() => {
    if (section.offsetHeight === offsetHeight) return;
    growth.disconnect();
    show();
  });
  growth.observe(section);
}

/** Replaces the isovalue section if the chosen layer has not been opened. */
function hiddenPart(title: string, { showChosen }: LayoutActions): TemplateResult {
  return html`<section class="section isovalue">
    <p class="quiet">${panelTexts.hiddenLayer(title)}</p>
    <div class="chips">
      <button type="button" class="chip" @click=${showChosen}>${panelTexts.showLayer}</button>
    </div>
  </section>`;
}

function facts(info: StoreInfo): string {
  const type = info.metadata.source?.type;
  const typeText = formatType(typeof type === "string" ? type : pageTexts.bits(info.mapping.bits));
  return `${formatDims(info.voxels)}, ${typeText}`;
}
