import { StreamError } from "../stream/types.ts";
import {
  readCamera,
  readColours,
  readNumbers,
  readOpacities,
  readProjection,
} from "../viewer/setting_text.ts";
import { surfacesAt } from "../viewer/surfaces.ts";
import { maxRate } from "../viewer/time.ts";
import { type PlayMode, playModes } from "../viewer/time_order.ts";
import { checkedTransform, type Transform } from "../viewer/transform.ts";
import type { Camera, Projection, Surface } from "../viewer/types.ts";

/** The isovalues of the attribute; undefined without it. */
export function isovaluesOf(element: Element): readonly number[] | undefined {
  return readNumbers(element.getAttribute("isovalue"));
}

/** Surfaces at these isovalues, with the colours and opacities of the attributes. `first`: see surfacesAt. */
export function surfacesOf(
  element: Element,
  isovalues: readonly number[],
  first = 0,
): readonly Surface[] {
  const colours = readColours(element.getAttribute("colour") ?? "");
  const opacities = readOpacities(element.getAttribute("opacity") ?? "");
  return surfacesAt(isovalues, colours, opacities, first);
}

export function projectionOf(element: Element): Projection {
  return readProjection(element.getAttribute("projection")) ?? "perspective";
}

/** The camera of the attributes. Undefined if it is absent or invalid. */
export function cameraOf(element: Element): Camera | undefined {
  const camera = readCamera(element.getAttribute("camera"));
  return camera && { ...camera, projection: projectionOf(element) };
}

/** The step of the attribute. Undefined if it is absent or invalid. */
export function stepOf(element: Element): number | undefined {
  const text = element.getAttribute("step") ?? "";
  return /^\d{1,9}$/.test(text) ? Number(text) : undefined;
}

/** The rate of the attribute. Undefined if it is absent or invalid. */
export function rateOf(element: Element): number | undefined {
  const [rate = 0, ...more] = readNumbers(element.getAttribute("rate")) ?? [];
  return more.length === 0 && rate > 0 && rate <= maxRate ? rate : undefined;
}

/** The play mode of the attribute `loop`. Undefined if it is absent or invalid. */
export function loopOf(element: Element): PlayMode | undefined {
  return playModes.find((mode) => mode === element.getAttribute("loop"));
}

/**
 * The transform of the attribute: 16 numbers, separated by commas. Null if the attribute is absent; undefined if it
 * is invalid.
 */
export function transformOf(element: Element): Transform | null | undefined {
  const text = element.getAttribute("transform");
  if (text === null) return null;
  try {
    return checkedTransform(readNumbers(text) ?? []);
  } catch {
    return undefined;
  }
}

/** The fault for an attribute with an invalid value. */
export function expected(name: string, found: string, what: string): StreamError {
  return new StreamError("bad-address", `${name}="${found}": expected ${what}`);
}
