import { elementTextsIn } from "../texts/element.ts";
import type { Language } from "../texts/languages.ts";
import type { PlayMode } from "../viewer/time_order.ts";
import type { Clip } from "../viewer/types.ts";
import { ControlsBar } from "./controls_bar.ts";
import { languageOf } from "./element_language.ts";
import { OverlayArea } from "./overlay_area.ts";
import { PictureArea } from "./picture_area.ts";
import { TimeControls } from "./time_controls.ts";

/** Actions of visitors on the parts of an element. */
export interface ElementPartsActions {
  setIsovalue(isovalue: number): void;
  /** A face of the clip box was dragged. */
  changeClip(clip: Clip): void;
  setStep(step: number): void;
  /** Steps per second while the scene plays. */
  setRate(rate: number): void;
  /** What follows the last step. */
  setLoop(mode: PlayMode): void;
  /** Plays the scene, or stops it. */
  togglePlay(): void;
  /** Returns to the first view. */
  reset(): void;
  /** The overlays above the picture could not be loaded. */
  overlaysFailed(error: unknown): void;
}

/** The parts inside of an element: picture, overlays, poster, controls, and the message of a fault. */
export class ElementParts {
  readonly picture: PictureArea;
  readonly overlays: OverlayArea;
  readonly controls: ControlsBar;
  readonly time: TimeControls;
  readonly #element: HTMLElement;
  readonly #poster = document.createElement("slot");
  readonly #message = document.createElement("div");
  #language: Language = "en";

  constructor(element: HTMLElement, root: ShadowRoot, actions: ElementPartsActions) {
    this.#element = element;
    this.picture = new PictureArea(() => element.getAttribute("aria-label"));
    this.overlays = new OverlayArea(actions.changeClip, actions.overlaysFailed);
    this.controls = new ControlsBar({
      setIsovalue: actions.setIsovalue,
      reset: actions.reset,
      toggleFullScreen: () => void toggleFullScreen(element),
    });
    this.time = new TimeControls(actions);
    this.controls.element.prepend(this.time.element);
    this.#poster.name = "poster";
    this.#poster.className = "poster";
    this.#message.className = "message";
    this.#message.setAttribute("part", "message");
    this.#message.setAttribute("role", "status");
    this.#message.hidden = true;
    root.append(
      this.picture.element,
      this.overlays.element,
      this.#poster,
      document.createElement("slot"),
      this.controls.element,
      this.#message,
    );
  }

  /** Follows the language of the element. */
  async translate(): Promise<void> {
    const language = languageOf(this.#element);
    if (language === this.#language) return;
    this.#language = language;
    const { element, overlay } = await elementTextsIn(language);
    if (language !== this.#language) return; // another was set in the meantime
    this.controls.translate(language, element);
    this.time.translate(language, element);
    this.picture.translate(element);
    this.overlays.translate(overlay);
  }

  showMessage(text: string): void {
    this.#message.textContent = text;
    this.#message.hidden = false;
  }

  hideMessage(): void {
    this.#message.hidden = true;
  }

  /** Shows the poster while there is no picture of the volume yet. */
  showPoster(): void {
    this.#poster.hidden = false;
  }

  /** Shows the canvas once it has a picture of the volume. */
  showCanvas(): void {
    this.#poster.hidden = true;
    this.picture.removeStill();
  }

  /** Removes the picture. */
  clear(): void {
    this.picture.removeStill();
    this.overlays.clear();
    this.showPoster();
  }
}

async function toggleFullScreen(element: HTMLElement): Promise<void> {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await element.requestFullscreen();
  } catch {
    // The page, or the frame around it, does not allow it.
  }
}
