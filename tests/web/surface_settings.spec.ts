// The sweep of an isovalue and the actions that end it, and the first isovalue of another store.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { SurfaceSettings } from "../../web/page/panel/surface_settings.ts";
import type { StoreInfo } from "../../web/stream/index.ts";
import type { Viewer } from "../../web/viewer/index.ts";

// The real module reads the colour scheme of the browser.
vi.mock("../../web/page/shell/theme.ts", () => ({ theme: () => "light", themeBackground: {} }));

const viewer = {
  setLook() {},
  setClip() {},
  setSlices() {},
  setSurfaces() {},
  on() {},
} as unknown as Viewer;
const info = { range: [0, 100], mapping: { scale: 1 }, metadata: {} } as unknown as StoreInfo;
let settings: SurfaceSettings;

beforeEach(() => {
  vi.stubGlobal("requestAnimationFrame", () => 1);
  vi.stubGlobal("cancelAnimationFrame", () => {});
  settings = new SurfaceSettings(viewer, { isovalues: [50], background: "#ffffff" }, () => {});
  settings.opened(info);
  settings.actions.toggleSweep();
  expect(settings.state.isSweeping).toBe(true);
});
afterEach(() => vi.unstubAllGlobals());

it.each([
  ["a surface is added", () => settings.actions.addSurface()],
  ["a surface is chosen", () => settings.actions.activate(0)],
  ["the volume is replaced", () => settings.opened(info)],
  ["the volume is closed", () => settings.closed()],
  ["an isovalue is typed", () => settings.actions.type("7")],
])("ends when %s", (_when, change) => {
  change();
  expect(settings.state.isSweeping).toBe(false);
});

it("leaves typed text unchanged until it is entered", () => {
  settings.actions.type("7");
  settings.actions.changeSurface(0, { isovalue: 60 });
  expect(settings.state.typed).toBe("7");
  settings.actions.type(undefined);
  settings.actions.enter(7);
  expect(settings.state.typed).toBeUndefined();
  expect(settings.surfaces[0]?.isovalue).toBe(7);
});

it("says once it rests the isovalue that a key or undo has set, until another change", () => {
  vi.useFakeTimers();
  try {
    const isovalue = () => settings.surfaces[0]?.isovalue ?? Number.NaN;
    settings.actions.slide(50);
    for (let i = 0; i < 10; ++i) {
      settings.step(1, "hundredth"); // a key that is held
      vi.advanceTimersByTime(120);
      expect(settings.announced).toBe("");
    }
    vi.advanceTimersByTime(500);
    const reached = isovalue();
    expect(settings.announced).toBe(`Isovalue ${reached}`);

    settings.actions.slide(7); // the slider says its value itself
    expect(settings.announced).toBe("");
    settings.actions.slide(reached);
    vi.advanceTimersByTime(1000);
    expect(settings.announced).toBe("");

    const at = (change: object) => settings.surfaces.map((surface) => ({ ...surface, ...change }));
    settings.restore(at({ isovalue: 8 }));
    vi.advanceTimersByTime(500);
    expect(settings.announced).toBe("Isovalue 8");
    settings.restore(at({ colour: "#ffffff" }));
    vi.advanceTimersByTime(1000);
    expect(settings.announced).toBe("");

    settings.step(1, "step");
    settings.actions.enter(9); // before it rests
    vi.advanceTimersByTime(1000);
    expect(settings.announced).toBe("");
    settings.step(1, "step");
    settings.closed();
    vi.advanceTimersByTime(1000);
    expect(settings.announced).toBe("");
  } finally {
    vi.useRealTimers();
  }
});

const suggesting = (isovalue: number) =>
  ({ ...info, metadata: { suggested_isovalues: [isovalue] } }) as unknown as StoreInfo;

it("shows the suggestion of another store instead of the first store's", () => {
  settings = new SurfaceSettings(viewer, { background: "#ffffff" }, () => {});
  settings.opened(suggesting(20));
  settings.actions.changeSurface(0, { colour: "#c65b4e" });
  expect(settings.hasSuggested).toBe(true);
  settings.opened(suggesting(30));
  expect(settings.surfaces).toEqual([{ isovalue: 30, colour: "#c65b4e", opacity: 1 }]);
});

it("keeps an isovalue that was chosen", () => {
  settings = new SurfaceSettings(viewer, { background: "#ffffff" }, () => {});
  settings.opened(suggesting(20));
  settings.actions.slide(25);
  settings.opened(suggesting(30));
  expect(settings.surfaces[0]?.isovalue).toBe(25);
});
