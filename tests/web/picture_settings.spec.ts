import { describe, expect, it } from "vitest";
import type { FieldInfo, StoreInfo } from "../../web/core/types.ts";
import { PictureSettings } from "../../web/viewer/picture_settings.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";
import { defaultLook } from "../../web/viewer/types.ts";

const withoutFields = { range: [3, 4], spacing: [1, 1, 1], fields: [] } as unknown as StoreInfo;
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
});
