// When the address bar is brought up to date.
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { defaultParts } from "../../web/overlay/parts.ts";
import { AddressBar } from "../../web/page/page_address.ts";
import { defaultLook } from "../../web/viewer/types.ts";

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

it("is written once, with what is shown last, when nothing changes any more", () => {
  let isovalue = 60;
  const pending: boolean[] = [];
  const rested: string[] = [];
  const bar: AddressBar = new AddressBar(
    () => ({
      volume: "engine",
      src: undefined,
      surfaces: [{ isovalue, colour: "#d9ccb3", opacity: 1 }],
      look: defaultLook,
      isThemeBackground: true,
      clip: { low: [0, 0, 0], high: [1, 1, 1], planes: [] },
      show: defaultParts,
      camera: undefined,
      measures: [],
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
  expect(rested).toEqual(["?volume=engine&isovalue=90"]);
});
