// What screen readers say of changes of the measurements.
import { expect, it } from "vitest";
import type { Measurement } from "../../web/measure/measurement.ts";
import { announcementOf } from "../../web/page/measure/announcement.ts";

const at = (x: number) => ({ position: [x, 0, 0] as [number, number, number] });
const angle: Measurement = { kind: "angle", points: [at(0), at(1), at(2)] };
const near: Measurement = { kind: "distance", points: [at(0), at(5)] };
const far: Measurement = { kind: "distance", points: [at(0), at(9)] };
const note: Measurement = { kind: "note", points: [at(0)], text: "here" };

/** The result is the place of the last point. */
function said(before: Measurement[], after: Measurement[], drafts: [number, number] = [0, 0]) {
  const [old, now] = drafts.map((count) => Array.from({ length: count }, (_, i) => at(i)));
  return announcementOf(
    { measurements: before, draft: old ?? [] },
    { measurements: after, draft: now ?? [] },
    ({ points }) => `${points.at(-1)?.position[0]}`,
  );
}

it.each<[what: string, Measurement[], Measurement[], string | undefined]>([
  ["a new one", [angle], [angle, near], "Distance: 5"],
  ["one that is the same as another", [near], [near, near], "Distance: 5"],
  ["a moved point", [angle, near, note], [angle, far, note], "Distance 2: 9"],
  ["a new text", [note], [{ ...note, text: "there" }], "Note 1: 0"],
  ["the removal of one", [angle, near, note], [angle, note], "Distance 2 removed"],
  ["the removal of the last one", [angle, near], [angle], "Distance 2 removed"],
  ["the removal of the only one", [angle], [], "No measurements"],
  ["the removal of all", [angle, near, note], [], "No measurements"],
  ["several new ones", [], [angle, near], "2 measurements"],
  ["several changes", [angle, near], [far, note], "2 measurements"],
  ["nothing", [angle], [{ ...angle }], undefined],
])("says %s", (_, before, after, text) => expect(said(before, after)).toBe(text));

it("says how many points are set", () => {
  expect(said([angle], [angle], [0, 1])).toBe("1 point set");
  expect(said([angle], [angle], [1, 2])).toBe("2 points set");
  expect(said([angle], [angle], [1, 0])).toBe("No point set");
  expect(said([angle], [angle], [2, 2])).toBeUndefined();
  // The last point completes the measurement.
  expect(said([], [near], [1, 0])).toBe("Distance: 5");
});
