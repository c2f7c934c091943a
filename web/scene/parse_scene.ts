import { StreamError } from "../stream/types.ts";
import type { SceneTime } from "../viewer/time.ts";
import type { Clip } from "../viewer/types.ts";
import { Member, maxInteger, sceneError } from "./member.ts";
import {
  type CameraDocument,
  type JsonObject,
  type LabelDocument,
  type LayerDocument,
  maxLayers,
  maxSceneBytes,
  maxScenePlanes,
  maxSteps,
  maxSurfacesOfLayer,
  type SceneDocument,
  type SurfaceDocument,
} from "./scene_document.ts";

/**
 * Reads a scene's document (shared/core/scene/SCENE.md), which is untrusted: UTF-8. Throws a StreamError, of
 * the kind `not-a-store` or `newer-version`, that names the member, what was expected and what was
 * found. It does not check addresses.
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
    camera: optional(root.at("camera"), readCamera, null),
    clip: readClip(root.at("clip")),
    background: optional(root.at("background"), (colour) => colour.colour(true), null),
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

function optional<T, None>(member: Member, read: (member: Member) => T, otherwise: None): T | None {
  return member.exists ? read(member) : otherwise;
}

function readLayer(layer: Member, steps: number): LayerDocument {
  layer.requireObject("a layer");
  const name = optional(layer.at("name"), (text) => text.text(), "");
  const group = optional(layer.at("group"), (text) => text.text(), "");
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

function readLabel(label: Member): LabelDocument {
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

function readCamera(camera: Member): CameraDocument {
  const angle = (key: string, otherwise: number, least: number, most: number) =>
    optional(camera.at(key), (found) => found.number(least, most), otherwise);
  return {
    target: camera.at("target").vector(),
    distance: camera.at("distance").number(1e-300),
    azimuth: angle("azimuth", 30, -1e6, 1e6),
    elevation: angle("elevation", 20, -90, 90),
    roll: angle("roll", 0, -1e6, 1e6),
    fieldOfView: angle("field_of_view", 30, 1, 120),
    isOrthographic: optional(camera.at("orthographic"), (found) => found.flag(), false),
  };
}

function readClip(clip: Member): Required<Clip> {
  const box = clip.at("box");
  return {
    low: box.exists ? box.at("low").vector(0, 1) : [0, 0, 0],
    high: box.exists ? box.at("high").vector(0, 1) : [1, 1, 1],
    planes: optional(clip.at("planes"), (list) => list.list(0, maxScenePlanes), []).map((plane) => {
      const normal = plane.at("normal").vector(-1e9, 1e9);
      const offset = plane.at("offset").number();
      if (!(Math.hypot(...normal) > 0)) plane.at("normal").refuse("a normal that is not 0");
      return { normal, offset };
    }),
    caps: optional(clip.at("caps"), (caps) => caps.flag(), false),
  };
}
