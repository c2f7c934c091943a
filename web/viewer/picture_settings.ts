import type { Category, FieldInfo, StoreInfo } from "../core/types.ts";
import type { ShownField } from "../stream/session.ts";
import { wholeVolume } from "./clipping.ts";
import { hasLines, lineTicks } from "./field_lines.ts";
import { shownRange } from "./field_of.ts";
import { greyRange } from "./grey_range.ts";
import type { RendererModule } from "./renderer_module.ts";
import { hasSlices, noSlices, slicePlanes, usableSlices } from "./slices.ts";
import { type Clip, defaultLook, type Legend, type Look, type Slices } from "./types.ts";

/**
 * The settings of a picture: look, clipping and slices, without the camera and the layers. The
 * viewer keeps them here, even without a renderer and a volume. `info` and `number` are those of
 * the first layer; `info` has the grid after the layer's transform.
 */
export class PictureSettings {
  look: Readonly<Look> = { ...defaultLook };
  clip: Clip = wholeVolume;
  #slices: Slices = noSlices;

  get slices(): Slices {
    return this.#slices;
  }

  set slices(slices: Slices) {
    this.#slices = usableSlices(slices);
  }

  /** The name of the field that colours represent. */
  get shownField(): string | null {
    return this.look.colourBy === "field" ? this.look.field.name : null;
  }

  get hasSlices(): boolean {
    return hasSlices(this.#slices);
  }

  /** `field`: the shown one, of the first layer that has it. `categories`: if its values are labels. */
  apply(
    renderer: RendererModule,
    info: StoreInfo | null,
    number: number,
    field: FieldInfo | null,
    categories: readonly Category[],
  ): void {
    renderer.picture.setClip(this.clip);
    renderer.picture.setCategories(categories);
    this.applyLook(renderer, info, field);
    this.applySlices(renderer, info, number);
  }

  /** `opacity`: of the background. */
  applyLook(
    renderer: RendererModule,
    info: StoreInfo | null,
    field: FieldInfo | null,
    opacity = 1,
  ): void {
    renderer.picture.setLook(this.look, this.#colourRange(info, field), opacity);
  }

  /** Without a volume, this does nothing: the planes depend on its grid. */
  applySlices(renderer: RendererModule, info: StoreInfo | null, number: number): void {
    if (!info) return;
    const range = this.#slices.range ?? greyRange(info);
    const { mapped = false } = this.#slices;
    renderer.picture.setSlices(number, slicePlanes(this.#slices, info), range, mapped);
  }

  /**
   * The meaning of colours; null if each surface has its own colour and there are no slices. `shown`: the field,
   * as the first layer that has it shows it; `categories`: if its values are labels, those around the surfaces.
   */
  legend(
    renderer: RendererModule,
    info: StoreInfo,
    shown: ShownField | null,
    categories: readonly Category[] | null = null,
  ): Legend | null {
    const { colourBy, colourMap } = this.look;
    const slices = this.hasSlices;
    const mapColours = () => renderer.picture.colours(colourMap, 16);
    const ofSlices = {
      range: this.#slices.range ?? greyRange(info),
      colours: this.#slices.mapped ? mapColours() : ["#000", "#fff"],
    };
    const withSlices = (legend: Legend): Legend => {
      if (slices) legend.slices = slices;
      if (slices && colourBy !== "isovalue") legend.ofSlices = ofSlices;
      return legend;
    };
    if (colourBy === "isosurface") {
      if (!slices) return null;
      return { colourBy: "isovalue", ...ofSlices, slices };
    }
    const legend: Legend = {
      colourBy,
      colours: mapColours(),
      range: this.#mappedRange(info, shown),
    };
    if (colourBy === "field") {
      if (!shown) return null;
      const { units } = shown.metadata;
      const { name, scale, steps, lines } = this.look.field;
      const range = this.#colourRange(info, shown.info);
      legend.range = range;
      const { hasMissing } = shown.info.mapping;
      legend.field = { name, ...(units && { units }), scale, ...(hasMissing && { hasMissing }) };
      if (categories) {
        legend.categories = categories;
        legend.colours = [];
        legend.range = null;
        return withSlices(legend);
      }
      const isStepped = steps > 1;
      const along =
        isStepped || lines > 0 ? renderer.picture.colours(colourMap, isStepped ? steps : 256) : [];
      if (hasLines(lines, scale, shown.info.mapping.scale)) {
        const ticks = lineTicks(range, scale, lines, along, steps);
        legend.lines = { interval: lines, ticks };
      }
      if (isStepped) legend.colours = stepped(along);
    }
    return withSlices(legend);
  }

  /** The range shown in the legend; null if it differs from view to view. */
  #mappedRange(info: StoreInfo, shown: ShownField | null): [number, number] | null {
    switch (this.look.colourBy) {
      case "depth":
        return null; // depends on the view
      case "level":
        return [0, 7];
      case "projection-error":
        return [0, 0.5];
      default:
        return this.#colourRange(info, shown?.info ?? null);
    }
  }

  /** The range of values, or of gradients, that is passed to the renderer for colouring. */
  #colourRange(info: StoreInfo | null, field: FieldInfo | null): [number, number] {
    if (!info) return [0, 1];
    const [low, high] = info.range;
    if (this.look.colourBy === "field") {
      const { range, scale } = this.look.field;
      return shownRange(range ?? field?.range ?? [0, 1], scale);
    }
    if (this.look.colourBy !== "gradient") return [low, high];
    // The largest gradient of the scale: half of the range of values within one cell, a sharp edge.
    return [0, (0.5 * (high - low)) / Math.min(...info.spacing)];
  }
}

/** Each colour for an equal part of a gradient. */
function stepped(colours: readonly string[]): string[] {
  return colours.flatMap((colour) => Array.from({ length: 8 }, () => colour));
}
