import { StreamError } from "../stream/types.ts";
import {
  readCamera,
  readColours,
  readNumbers,
  readOpacities,
  readProjection,
} from "../viewer/setting_text.ts";
import { surfacesAt } from "../viewer/surfaces.ts";
import type { Camera, Projection, Surface } from "../viewer/types.ts";

/** The isovalues of the attribute; undefined without it. */
export function isovaluesOf(element: Element): readonly number[] | undefined {
  return readNumbers(element.getAttribute("isovalue"));
}

/** Surfaces at these isovalues, with the colours and opacities of the attributes. */
export function surfacesOf(element: Element, isovalues: readonly number[]): readonly Surface[] {
  const colours = readColours(element.getAttribute("colour") ?? "");
  const opacities = readOpacities(element.getAttribute("opacity") ?? "");
  return surfacesAt(isovalues, colours, opacities);
}

export function projectionOf(element: Element): Projection {
  return readProjection(element.getAttribute("projection")) ?? "perspective";
}

/** The camera of the attributes; undefined if they have none that is valid. */
export function cameraOf(element: Element): Camera | undefined {
  const camera = readCamera(element.getAttribute("camera"));
  return camera && { ...camera, projection: projectionOf(element) };
}

/** The fault for an attribute with an invalid value. */
export function expected(name: string, found: string, what: string): StreamError {
  return new StreamError("bad-address", `${name}="${found}": expected ${what}`);
}
