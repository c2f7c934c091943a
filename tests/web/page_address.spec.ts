// The times at which the address bar is updated, and its content.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { defaultParts } from "../../web/overlay/parts.ts";
import {
  AddressBar,
  type AddressState,
  addressOf,
  awaitsRange,
} from "../../web/page/address/page_address.ts";
import { type Clip, defaultLook, type Slices } from "../../web/viewer/types.ts";

const replaceState = vi.fn();
beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("window", globalThis);
  vi.stubGlobal("location", { pathname: "/", search: "?volume=engine" });
  vi.stubGlobal("history", { replaceState });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
  replaceState.mockClear();
});

const view: AddressState = {
  volume: "engine",
  scene: undefined,
  src: undefined,
  spacing: undefined,
  surfaces: [{ isovalue: 60, colour: "#d9ccb3", opacity: 1 }],
  look: defaultLook,
  isThemeBackground: true,
  clip: { low: [0, 0, 0], high: [1, 1, 1], planes: [] },
  slices: { along: [null, null, null] },
  show: defaultParts,
  camera: undefined,
  isDefaultCamera: true,
  time: undefined,
  opened: {
    look: defaultLook,
    isThemeBackground: true,
    clip: { low: [0, 0, 0], high: [1, 1, 1], planes: [] },
    slices: { along: [null, null, null] },
  },
  measures: null,
  measurements: null,
  layers: null,
};

it("is written once, with the last state, when nothing changes any more", () => {
  let isovalue = 60;
  const pending: boolean[] = [];
  const rested: string[] = [];
  const bar: AddressBar = new AddressBar(
    () => ({
      ...view,
      surfaces: [{ isovalue, colour: "#d9ccb3", opacity: 1 }],
    }),
    () => pending.push(bar.isPending),
    (query) => rested.push(query),
  );
  for (; isovalue < 90; ++isovalue) {
    bar.changed();
    vi.advanceTimersByTime(100);
  }
  expect(replaceState).not.toHaveBeenCalled();
  vi.runAllTimers();
  expect(replaceState.mock.calls).toEqual([[null, "", "/?volume=engine&isovalue=90"]]);
  expect(pending).toEqual([true, false]);
  expect(rested).toEqual(["?isovalue=90"]);
});

it("has only the settings that differ from the scene", () => {
  const clip = { low: [0, 0, 0], high: [1, 1, 0.5], planes: [], caps: false } as Clip;
  const slices: Slices = { along: [0.5, null, null] };
  const look = { ...defaultLook, kind: "exact", background: "#203040" } as const;
  const opened = { look, isThemeBackground: false, clip, slices };
  const same = { ...view, ...opened, opened };
  expect(addressOf(same)).toEqual({ volume: "engine", isovalues: [60] });
  const { volume: _, isovalues: __, ...changed } = addressOf({ ...view, opened, measures: [] });
  expect(changed).toEqual({
    kind: "automatic",
    background: defaultLook.background,
    clip: view.clip,
    slices: view.slices,
    measures: [],
  });
});

it("leaves out measurements that do not fit into a request, and reports this", () => {
  let measures = ["point,1,2,3"];
  const rested: [string, boolean][] = [];
  const bar = new AddressBar(
    () => ({ ...view, measures }),
    () => {},
    (query, _, hasMeasures) => rested.push([query, hasMeasures]),
  );
  bar.write();
  measures = Array(500).fill(
    "distance,12.345678,12.345678,12.345678,12.345678,12.345678,12.345678",
  );
  bar.write();
  expect(replaceState.mock.calls.map(([, , address]) => address)).toEqual([
    "/?volume=engine&isovalue=60&measure=point,1,2,3",
    "/?volume=engine&isovalue=60",
  ]);
  // Undo has them nevertheless.
  expect(rested).toEqual([
    ["?isovalue=60&measure=point,1,2,3", true],
    [expect.stringContaining("?isovalue=60&measure=distance,12.345678"), false],
  ]);
});

it("has the camera only if it is not the page's default, which depends on the window", () => {
  const camera = {
    azimuth: 0,
    elevation: 0,
    distance: 5,
    target: [0, 0, 0] as [number, number, number],
    roll: 0,
    fieldOfView: 30,
    projection: "orthographic" as const,
  };
  expect(addressOf({ ...view, camera }).camera).toBeUndefined();
  expect(addressOf({ ...view, camera }).projection).toBe("orthographic");
  const moved = addressOf({ ...view, camera, isDefaultCamera: false });
  expect(moved.camera).toMatchObject({ distance: 5 });
});

it("names the field that colours show, and no range that follows from the values of a scene", () => {
  const field = { name: "p", range: [0, 100], scale: "linear", steps: 0, lines: 0 } as const;
  const shown = { ...defaultLook, colourBy: "field", field } as const;
  const opened = { ...view.opened, look: { ...defaultLook, field } };
  // The scene has the field, but does not show it.
  expect(addressOf({ ...view, look: shown, opened })).toMatchObject({ colourBy: "field", field });
  const same = addressOf({ ...view, look: shown, opened: { ...opened, look: shown } });
  expect([same.colourBy, same.field]).toEqual([undefined, undefined]);
  const awaited = { ...shown, field: { ...field, range: null } };
  expect(awaitsRange({ ...view, look: awaited })).toBe(true);
  const ofScene = { ...opened, look: awaited };
  expect(awaitsRange({ ...view, look: awaited, opened: ofScene })).toBe(false);
});
