// The actions of the panel's controls if settings have changed since the panel was drawn.
import { beforeEach, describe, expect, it, vi } from "vitest";
import { clippingSection } from "../../web/page/panel/clipping_section.ts";
import { DisplaySettings } from "../../web/page/panel/display_settings.ts";
import { lightSection } from "../../web/page/panel/light_section.ts";
import type { PanelActions, PanelState } from "../../web/page/panel/panel_state.ts";
import { slicesSection } from "../../web/page/panel/slices_section.ts";
import { SurfaceSettings } from "../../web/page/panel/surface_settings.ts";
import { wholeVolume } from "../../web/viewer/clipping.ts";
import { defaultLook, maxSurfaces } from "../../web/viewer/types.ts";
import type { Viewer } from "../../web/viewer/viewer.ts";

// The real module reads the colour scheme of the browser.
vi.mock("../../web/page/shell/theme.ts", () => ({ theme: () => "light", themeBackground: {} }));

const info = {
  range: [0, 100],
  voxels: [5, 5, 5],
  spacing: [1, 1, 1],
  origin: [0, 0, 0],
  direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  mapping: { scale: 1 },
  metadata: {},
};
const planes = [{ normal: [1, 0, 0], offset: 2 }];

type Listener = (event: { currentTarget: object; target?: object }) => void;
type Template = { strings: readonly string[]; values: readonly unknown[] };

let settings: DisplaySettings;
let surfaces: SurfaceSettings;
let state: PanelState;
let actions: PanelActions;

beforeEach(() => {
  const viewer = {
    look: defaultLook,
    info,
    on() {},
    setLook: (change: object) => Object.assign(viewer, { look: { ...viewer.look, ...change } }),
    setClip: (clip: object) => Object.assign(viewer, { clip }),
    setSlices: (slices: object) => Object.assign(viewer, { slices }),
    setSurfaces() {},
  };
  const url = { isovalues: [50], background: "#ffffff", clip: { ...wholeVolume, planes } };
  const args = [viewer as unknown as Viewer, url as never, () => {}] as const;
  vi.stubGlobal("cancelAnimationFrame", () => {});
  settings = new DisplaySettings(...args);
  surfaces = new SurfaceSettings(...args);
  // The state with which the panel was drawn. It does not change below.
  state = { ...settings.state, ...surfaces.state, info } as unknown as PanelState;
  actions = { ...settings.actions, ...surfaces.actions } as PanelActions;
});

/** The listeners of an event in a template, in the order of the page. */
function listeners(template: unknown, event: string): Listener[] {
  if (Array.isArray(template)) return template.flatMap((each) => listeners(each, event));
  const { strings, values } = (template ?? {}) as Partial<Template>;
  if (!strings || !values) return [];
  return values.flatMap((value, i) =>
    typeof value === "function" && strings[i]?.endsWith(`@${event}=`)
      ? [value as Listener]
      : listeners(value, event),
  );
}

describe("the section of slices", () => {
  it("keeps a slice that was just shown, and hides it when its button is pressed again", () => {
    const [x, y] = listeners(slicesSection(state, actions), "click");
    x?.({ currentTarget: {} });
    y?.({ currentTarget: {} });
    expect(settings.state.slices.along).toEqual([0.5, 0.5, null]);
    x?.({ currentTarget: {} });
    expect(settings.state.slices.along).toEqual([null, 0.5, null]);
  });

  it("keeps the value of black if the value of white is entered next", () => {
    actions.changeSlices((now) => ({ ...now, along: [0.5, null, null] }));
    state = { ...state, slices: settings.state.slices };
    const [, , black, white] = listeners(slicesSection(state, actions), "change");
    const field = { value: "20" };
    black?.({ currentTarget: field });
    white?.({ currentTarget: { value: "70" } });
    expect(settings.state.slices.range).toEqual([20, 70]);
    field.value = "80"; // is not below white
    black?.({ currentTarget: field });
    expect([settings.state.slices.range, field.value]).toEqual([[20, 70], "20"]);
  });

  it("shows values in the colours of a map, and in grey again", () => {
    actions.changeSlices((now) => ({ ...now, along: [0.5, null, null] }));
    state = { ...state, slices: settings.state.slices };
    const [, colours] = listeners(slicesSection(state, actions), "change");
    colours?.({ currentTarget: { value: "magma" } });
    expect(settings.state.slices.mapped).toBe(true);
    expect(settings.state.look.colourMap).toBe("magma");
    colours?.({ currentTarget: { value: "grey" } });
    expect(settings.state.slices).not.toHaveProperty("mapped");
  });
});

describe("the section of clipping", () => {
  it("keeps the changes of another control", () => {
    const template = clippingSection(state, actions);
    const [x, y, , plane] = listeners(template, "input");
    const [, , caps] = listeners(template, "click");
    x?.({ currentTarget: { minValue: 0.2, maxValue: 1 } });
    y?.({ currentTarget: { minValue: 0, maxValue: 0.6 } });
    caps?.({ currentTarget: {} });
    expect(settings.state.clip).toMatchObject({ low: [0.2, 0, 0], high: [1, 0.6, 1], caps: true });
    plane?.({ currentTarget: { value: "0.25" } });
    expect(settings.state.clip).toMatchObject({ caps: true, planes: [{ offset: 1 }] });
  });

  it("does not move a plane that has replaced the one that was drawn", () => {
    const sliders = listeners(clippingSection(state, actions), "input");
    const other = { normal: [0, 1, 0] as [number, number, number], offset: 3 };
    actions.changeClip((now) => ({ ...now, planes: [other] }));
    sliders[3]?.({ currentTarget: { value: "0.25" } });
    expect(settings.state.clip.planes).toEqual([other]);
  });
});

it("each slider of the light keeps the settings of the others", () => {
  const [key, sky] = listeners(lightSection(state, actions), "input");
  key?.({ currentTarget: { value: "1.5" } });
  actions.turnLight(10, 0);
  const { azimuth } = settings.state.look.light;
  sky?.({ currentTarget: { value: "0.25" } });
  expect(settings.state.look.light).toMatchObject({ key: 1.5, sky: 0.25, azimuth });
});

describe("the list of surfaces", () => {
  it("does not lose its last surface when it is removed twice", () => {
    actions.addSurface();
    actions.removeSurface(0);
    actions.removeSurface(0);
    expect(surfaces.surfaces.length).toBe(1);
  });

  it("has no more surfaces than can be shown", () => {
    for (let i = 0; i <= maxSurfaces; i++) actions.addSurface();
    expect(surfaces.surfaces.length).toBe(maxSurfaces);
  });

  it("has an active surface, even if a removed one is chosen", () => {
    actions.activate(1);
    expect(surfaces.state.active).toBe(0);
  });
});
