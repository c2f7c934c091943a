// The isovalue that moves by itself, and what ends it.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { DisplaySettings } from "../../web/page/display_settings.ts";
import type { StoreInfo } from "../../web/stream/index.ts";
import type { Viewer } from "../../web/viewer/index.ts";

// It reads the colour scheme of the browser.
vi.mock("../../web/page/theme.ts", () => ({ theme: () => "light", themeBackground: {} }));

const viewer = { setLook() {}, setClip() {}, setSurfaces() {}, on() {} } as unknown as Viewer;
const info = { range: [0, 100], mapping: { scale: 1 }, metadata: {} } as unknown as StoreInfo;
let settings: DisplaySettings;

beforeEach(() => {
  vi.stubGlobal("requestAnimationFrame", () => 1);
  vi.stubGlobal("cancelAnimationFrame", () => {});
  settings = new DisplaySettings(viewer, { isovalues: [50], background: "#ffffff" }, () => {});
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
])("ends when %s", (_when, change) => {
  change();
  expect(settings.state.isSweeping).toBe(false);
});
