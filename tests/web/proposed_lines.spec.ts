// The interval of contour lines while the range of the colours changes.
import { expect, test, vi } from "vitest";
import { DisplaySettings } from "../../web/page/panel/display_settings.ts";
import { fieldNotes } from "../../web/page/panel/legend.ts";
import { defaultLook, type FieldLook, type Legend, type Look } from "../../web/viewer/types.ts";
import type { Viewer } from "../../web/viewer/viewer.ts";

// The real module reads the colour scheme of the browser.
vi.mock("../../web/page/shell/theme.ts", () => ({ theme: () => "light", themeBackground: {} }));

/** A viewer whose field has values from 0 to 1000, of which the surface has those from 100 to 300. */
class FakeViewer {
  look: Look = defaultLook;
  progress: { state: string } | null = null;
  fieldRange: [number, number] | undefined = [100, 300];
  readonly layers = [{ info: { fields: [{ name: "p", range: [0, 1000] }] } }];
  readonly #listeners = new Map<string, () => void>();
  setClip() {}
  setSlices() {}
  setLook(change: Partial<Look>) {
    this.look = { ...this.look, ...change };
  }
  on(event: string, listener: () => void) {
    this.#listeners.set(event, listener);
  }
  complete() {
    this.progress = { state: "complete" };
    this.#listeners.get("progress")?.();
  }
  get field(): FieldLook {
    return this.look.field;
  }
}

const p: FieldLook = { name: "p", range: null, scale: "linear", steps: 0, lines: 0 };

function opened(field: FieldLook = p) {
  const viewer = new FakeViewer();
  const url = { background: "#ffffff", colourBy: "field", field } as const;
  const settings = new DisplaySettings(viewer as unknown as Viewer, url, () => {});
  const change = (part: Partial<FieldLook>) =>
    settings.actions.changeLook({ field: { ...viewer.field, ...part } });
  return { viewer, change };
}

test("a proposed interval follows the range", () => {
  const { viewer, change } = opened();
  change({ lines: 100 }); // proposed for 0 to 1000
  viewer.complete();
  expect(viewer.field).toMatchObject({ range: [100, 300], lines: 20 });
  change({ range: [0, 1000] });
  expect(viewer.field.lines).toBe(100);
  change({ range: [0, 20] });
  expect(viewer.field.lines).toBe(2);
  change({ range: null }); // fits it to the surface
  expect(viewer.field).toMatchObject({ range: [100, 300], lines: 20 });
  change({ scale: "logarithmic" });
  expect(viewer.field.lines).toBe(0.05);
  change({ range: [1, 1000] });
  expect(viewer.field.lines).toBe(0.2);
});

test("an interval that was entered stays", () => {
  const { viewer, change } = opened();
  viewer.complete();
  change({ lines: 7 });
  for (const range of [[0, 1000], [0, 20], null] as const) {
    change({ range });
    expect(viewer.field.lines).toBe(7);
  }
  change({ steps: 5, scale: "symmetric" });
  expect(viewer.field.lines).toBe(7);
  // It would have another meaning.
  change({ scale: "logarithmic" });
  expect(viewer.field.lines).toBe(0.05);
  change({ lines: 0 });
  change({ range: [1, 1000] });
  expect(viewer.field.lines).toBe(0);
});

test("that of an address stays, though it would be proposed for the whole range", () => {
  const { viewer } = opened({ ...p, lines: 100 });
  viewer.complete();
  expect(viewer.field).toMatchObject({ range: [100, 300], lines: 100 });
});

test("the legend states one decade, several, and values with units", () => {
  const notes = (scale: FieldLook["scale"], interval: number) =>
    fieldNotes({
      colourBy: "field",
      field: { name: "p", units: "Pa", scale },
      lines: { interval, ticks: [] },
    } as unknown as Legend);
  expect(notes("logarithmic", 1)).toEqual(["Lines every decade"]);
  expect(notes("logarithmic", 2)).toEqual(["Lines every 2 decades"]);
  expect(notes("logarithmic", 0.5)).toEqual(["Lines every 0.5 decades"]);
  expect(notes("linear", 1)).toEqual(["Lines every 1 Pa"]);
});
