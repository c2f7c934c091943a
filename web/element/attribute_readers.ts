import type { SceneSource } from "../scene/scene_source.ts";
import type { Source } from "../stream/source.ts";
import type { StreamError } from "../stream/types.ts";
import { maxRate } from "../viewer/time.ts";
import { type PlayMode, playModes } from "../viewer/time_order.ts";
import type { Camera } from "../viewer/types.ts";
import { cameraOf, expected, loopOf, rateOf, stepOf } from "./element_attributes.ts";
import { sceneOf } from "./element_scene.ts";
import { sourceOf } from "./element_source.ts";
import { type Link, linkedParts, readLink } from "./link_groups.ts";
import { readParts, shownParts } from "./overlay_area.ts";

/**
 * Reads attributes of an element whose text may be invalid. Each function returns null if the attribute is absent.
 * If its text is invalid, the function reports a fault and returns undefined.
 */
export class AttributeReaders {
  readonly #element: Element;
  readonly #fault: (error: StreamError) => void;

  constructor(element: Element, fault: (error: StreamError) => void) {
    this.#element = element;
    this.#fault = fault;
  }

  source(): Source | null | undefined {
    return this.#read("src", "the http or https address of a store", (text) =>
      sourceOf(text, document.baseURI),
    );
  }

  scene(): (() => Promise<SceneSource>) | null | undefined {
    return this.#read("scene", "the http or https address of a scene", (text) =>
      sceneOf(text, document.baseURI),
    );
  }

  step(): number | null | undefined {
    return this.#read("step", "a whole number from 0", () => stepOf(this.#element));
  }

  rate(): number | null | undefined {
    return this.#read("rate", `a number above 0 and at most ${maxRate}`, () =>
      rateOf(this.#element),
    );
  }

  loop(): PlayMode | null | undefined {
    return this.#read("loop", `one of ${playModes.join(", ")}`, () => loopOf(this.#element));
  }

  camera(): Camera | null | undefined {
    return this.#read("camera", "azimuth,elevation,distance,x,y,z", () => cameraOf(this.#element));
  }

  show(): ReturnType<typeof readParts> | null {
    return this.#read("show", `some of ${shownParts.join(",")}`, readParts);
  }

  link(): Link | null | undefined {
    const what = `a name, or a name with some of ${linkedParts.join(",")}, as in brains:camera`;
    return this.#read("link", what, readLink);
  }

  #read<T>(
    name: string,
    what: string,
    read: (text: string) => T | undefined,
  ): T | null | undefined {
    const text = this.#element.getAttribute(name);
    if (text === null || (text === "" && name !== "src" && name !== "scene")) return null;
    const value = read(text);
    if (value === undefined) this.#fault(expected(name, text, what));
    return value;
  }
}
