import { StreamError } from "../stream/types.ts";
import type { SceneTime } from "../viewer/time.ts";
import type { Label } from "../viewer/types.ts";
import { Member, maxInteger, optional, sceneError } from "./member.ts";
import { readPicture } from "./parse_picture.ts";
import {
  type JsonObject,
  type LayerDocument,
  maxLayers,
  maxSceneBytes,
  maxSteps,
  maxSurfacesOfLayer,
  type SceneDocument,
  type SurfaceDocument,
} from "./scene_document.ts";

/**
 * Reads a scene's document (shared/core/scene/SCENE.md) in UTF-8, which is untrusted. Throws a StreamError of the
 * kind `not-a-store` or `newer-version`, whose message names the member, what was expected and what was found.
 * Does not check addresses.
 */
export function parseScene(bytes: Uint8Array): SceneDocument {
  if (bytes.length > maxSceneBytes) {
    throw sceneError(`expected at most ${maxSceneBytes} bytes, found ${bytes.length}`);
  }
  const json = jsonOf(bytes);
  const root = new Member(json);
  const format = root.at("format");
  if (!format.is("isosplat-scene")) format.refuse('"isosplat-scene"');
  const version = root.at("version").number(1);
  if (version !== 1) {
    throw new StreamError(
      "newer-version",
      `scene: version: expected 1, found ${version}: use a newer Isosplat`,
    );
  }
  const name = optional(root.at("name"), (text) => text.text(), "");
  const time = optional(root.at("time"), readTime, null);
  const layers = root.at("layers").list(1, maxLayers);
  return {
    name,
    time,
    step: time ? (root.at("time").at("step").index(time.values.length) ?? 0) : 0,
    layers: layers.map((layer) => readLayer(layer, time?.values.length ?? 0)),
    ...readPicture(root),
    json: json as JsonObject,
  };
}

function jsonOf(bytes: Uint8Array): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw sceneError("expected JSON in UTF-8: check it with a JSON tool");
  }
}

function readLayer(layer: Member, steps: number): LayerDocument {
  layer.requireObject("a layer");
  const name = optional(layer.at("name"), (text) => text.text(), "");
  const group = optional(layer.at("group"), (text) => text.text(), "");
  const partOf = optional(layer.at("part_of"), (text) => text.text(), "");
  const stores = layer.at("stores");
  // A layer that does not change with time has one store for all steps.
  const paths =
    steps > 0 && stores.exists
      ? stores.list(steps, steps).map((path) => path.text())
      : [layer.at("store").text()];
  if (paths.includes("")) layer.refuse("a layer with a store");
  return {
    name,
    group,
    partOf,
    stores: paths,
    surfaces: optional(
      layer.at("surfaces"),
      (list) => list.list(0, maxSurfacesOfLayer).map(readSurface),
      [],
    ),
    visible: optional(layer.at("visible"), (visible) => visible.flag(), true),
    transform: optional(layer.at("transform"), readTransform, null),
    label: optional(layer.at("label"), readLabel, null),
  };
}

function readSurface(surface: Member): SurfaceDocument {
  surface.requireObject("a surface");
  return {
    isovalue: surface.at("isovalue").number(),
    colour: optional(surface.at("colour"), (colour) => colour.colour(false), null),
    opacity: optional(surface.at("opacity"), (opacity) => opacity.number(0, 1), 1),
  };
}

function readLabel(label: Member): Label {
  label.requireObject("a label");
  return {
    value: label.at("value").integer(-maxInteger),
    voxels: label.at("voxels").integer(0),
    volume: label.at("volume").number(0),
  };
}

function readTransform(transform: Member): number[] {
  const entries = transform.list(16, 16);
  const numbers = entries.map((entry) => entry.number());
  for (const [i, expected] of [0, 0, 0, 1].entries()) {
    if (numbers[12 + i] !== expected) entries[12 + i]?.refuse(String(expected));
  }
  return numbers;
}

function readTime(time: Member): Required<SceneTime> {
  const values: number[] = [];
  for (const step of time.at("steps").list(1, maxSteps)) {
    const value = step.number();
    if (value <= (values.at(-1) ?? Number.NEGATIVE_INFINITY)) {
      step.refuse("a number above that of the step before");
    }
    values.push(value);
  }
  return { values, unit: optional(time.at("unit"), (unit) => unit.text(64), "") };
}
