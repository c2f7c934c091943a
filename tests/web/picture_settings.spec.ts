import { describe, expect, it } from "vitest";
import type { FieldInfo, StoreInfo } from "../../web/core/types.ts";
import type { ShownField } from "../../web/stream/session.ts";
import { PictureSettings } from "../../web/viewer/picture_settings.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";
import { defaultLook } from "../../web/viewer/types.ts";

const withoutFields = {
  range: [3, 4],
  spacing: [1, 1, 1],
  fields: [],
  metadata: {},
} as unknown as StoreInfo;
const pressure = { name: "pressure", range: [900, 1100] } as unknown as FieldInfo;

/** The range of the colours that settings pass to the renderer. */
function coloursOf(range: [number, number] | null, field: FieldInfo | null): unknown {
  const settings = new PictureSettings();
  settings.look = {
    ...defaultLook,
    colourBy: "field",
    field: { ...defaultLook.field, name: "pressure", range },
  };
  let found: unknown;
  const picture = { setLook: (_: unknown, colours: unknown) => (found = colours) };
  settings.applyLook({ picture } as unknown as RendererModule, withoutFields, field);
  return found;
}

describe("the colours of a field", () => {
  it("have its range, also if the first layer does not have the field", () => {
    expect(coloursOf(null, pressure)).toEqual([900, 1100]);
    expect(coloursOf([1000, 1001], pressure)).toEqual([1000, 1001]);
    expect(coloursOf(null, null)).toEqual([0, 1]);
  });

  it("have lines in the legend where lines are drawn, on the colours of the steps", () => {
    const lines = (interval: number, steps: number) => {
      const settings = new PictureSettings();
      const field = { ...defaultLook.field, name: "pressure", steps, lines: interval };
      settings.look = { ...defaultLook, colourBy: "field", field };
      // From black to white.
      const colours = (_: unknown, count: number) =>
        Array.from({ length: count }, (_, i) => Math.round((255 * i) / (count - 1))).map(
          (grey) => `rgb(${grey} ${grey} ${grey})`,
        );
      const renderer = { picture: { colours } } as unknown as RendererModule;
      const info = { ...pressure, mapping: { scale: 0.1 } } as unknown as FieldInfo;
      const shown = { info, metadata: {} } as unknown as ShownField;
      const found = settings.legend(renderer, withoutFields, shown)?.lines;
      return found?.ticks.map(({ at, isDark }) => [at, isDark]);
    };
    // Bright in the whole map, and in the dark one of two steps.
    expect(lines(996, 0)).toEqual([[0.48, true]]);
    expect(lines(996, 2)).toEqual([[0.48, false]]);
    // More than 50 ticks, and more than 16 lines per quantized value.
    expect(lines(0.1 / 15, 0)).toEqual([]);
    expect(lines(0.1 / 17, 0)).toBeUndefined();
  });
});
