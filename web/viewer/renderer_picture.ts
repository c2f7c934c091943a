import * as layouts from "../../build/wasm/web/layouts.js";
import type { Category } from "../core/types.ts";
import { colourChannels } from "./colour_channels.ts";
import { writeCamera } from "./renderer_camera.ts";
import { RendererError } from "./renderer_error.ts";
import type { RendererInstance } from "./renderer_instance.ts";
import {
  type Camera,
  type Clip,
  type ColourMap,
  colourings,
  colourMaps,
  fieldScales,
  type Look,
  type SlicePlane,
  type Splats,
  shadings,
  splatKinds,
} from "./types.ts";

/** Where a field has no value: RenderSettings::field_missing_colour. */
const missingColour: [number, number, number] = [0.62, 0.62, 0.62];

/** The picture that a renderer draws: camera, look and light, clipping and slices. */
export class RendererPicture {
  readonly #instance: RendererInstance;
  #categories: readonly Category[] = [];
  #splats: Splats = { kind: "ellipse", shading: "smooth" };

  constructor(instance: RendererInstance) {
    this.#instance = instance;
  }

  /** As set by setSplats(); at first those of RenderSettings. */
  get splats(): Splats {
    return this.#splats;
  }

  setSplats(splats: Splats): void {
    this.#splats = splats;
    const { kind, shading } = splats;
    const exports = this.#instance.exports;
    exports._isosplat_renderer_set_splats(splatKinds.indexOf(kind), shadings.indexOf(shading));
  }

  /** range: of the quantity that the colour map shows. opacity: of the background. */
  setLook(look: Look, [colourLow, colourHigh]: readonly [number, number], opacity = 1): void {
    layouts.writeAppearance(this.#instance.view(), this.#instance.scratch, {
      colourLow,
      colourHigh,
      colourBy: colourings.indexOf(look.colourBy),
      colourMap: colourMaps.indexOf(look.colourMap),
      background: [...colourChannels(look.background), opacity],
      fieldMissing: missingColour,
      fieldScale: fieldScales.indexOf(look.field.scale),
      fieldSteps: look.field.steps,
      fieldLines: look.field.lines,
      eyeDome: look.eyeDome,
    });
    this.#instance.exports._isosplat_renderer_set_appearance(this.#instance.scratch);
    layouts.writeLight(this.#instance.view(), this.#instance.scratch, look.light);
    this.#instance.exports._isosplat_renderer_set_light(this.#instance.scratch);
  }

  /** The categories of the field that colours show, by value; none: its values are no labels. */
  setCategories(categories: readonly Category[]): void {
    if (categories.length === 0 && this.#categories.length === 0) return;
    this.#categories = categories;
    const { exports } = this.#instance;
    const first = categories[0]?.value ?? 0;
    const count = categories.length > 0 ? (categories.at(-1)?.value ?? 0) - first + 1 : 0;
    const colours = new Uint8Array(3 * count);
    for (const { value, colour } of categories) {
      const channels = colourChannels(colour).map((channel) => Math.round(255 * channel));
      colours.set(channels, 3 * (value - first));
    }
    const at = exports._malloc(Math.max(1, colours.length));
    if (at === 0) throw new RendererError("no memory for the colours of labels");
    exports.HEAPU8.set(colours, at);
    exports._isosplat_renderer_set_categories(first, at, count);
    exports._free(at);
  }

  /** `count` evenly spaced colours of a colour map, from low to high, as CSS colours. */
  colours(map: ColourMap, count: number): string[] {
    const at = this.#instance.exports._isosplat_renderer_colour_map(colourMaps.indexOf(map));
    return Array.from({ length: count }, (_, i) => {
      const last = layouts.colourMapColours - 1;
      const colour = at + 3 * Math.round((last * i) / (count - 1));
      return `rgb(${this.#instance.exports.HEAPU8.subarray(colour, colour + 3).join(" ")})`;
    });
  }

  setClip({ low, high, planes, caps }: Clip): void {
    const used = planes.slice(0, layouts.maxClipPlanes);
    const data = this.#instance.view();
    const planesAt = this.#instance.scratch + layouts.clipBoxBytes;
    layouts.writeClipBox(data, this.#instance.scratch, { low, high, caps: caps ? 1 : 0 });
    used.forEach((plane, i) => {
      layouts.writePlane(data, planesAt + i * layouts.planeBytes, plane);
    });
    this.#instance.exports._isosplat_renderer_set_clipping(
      this.#instance.scratch,
      planesAt,
      used.length,
    );
  }

  /**
   * Sets the slices of one volume. `range`: the values shown as black and white, unless slices have
   * the colours of isovalues. isMapped: in the colours of the map instead of greys.
   */
  setSlices(
    volume: number,
    planes: readonly SlicePlane[],
    [low, high]: readonly [number, number],
    isMapped: boolean,
  ): void {
    const used = planes.slice(0, layouts.maxSlices);
    const data = this.#instance.view();
    used.forEach((plane, i) => {
      layouts.writePlane(data, this.#instance.scratch + i * layouts.planeBytes, plane);
    });
    this.#instance.exports._isosplat_renderer_set_slices(
      volume,
      this.#instance.scratch,
      used.length,
      low,
      high,
      Number(isMapped),
    );
  }

  setCamera(camera: Camera): void {
    writeCamera(this.#instance, camera);
    this.#instance.exports._isosplat_renderer_set_camera(this.#instance.scratch);
  }
}
