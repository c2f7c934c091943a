import { expect, it } from "vitest";
import { labelPlace } from "../../web/measure/label_place.ts";

const label = "254.3 mm";
const letter = 12;
const middle = { x: 100, y: 100 };
/** The ends of a distance, whose middle is `middle`. */
const ends = (x: number, y: number) => [
  { x: 100 - x, y: 100 - y },
  { x: 100 + x, y: 100 + y },
];
/** Whether a circle of 4 px around the point is below the label, in a browser's usual font. */
function isCovered(point: { x: number; y: number }, place: ReturnType<typeof labelPlace>): boolean {
  const width = 52;
  const left = place.x - { start: 0, middle: width / 2, end: width }[place.anchor];
  const isBeside = point.x + 4 < left || point.x - 4 > left + width;
  return !isBeside && point.y + 4 > place.y - 9 && point.y - 4 < place.y + 2;
}

it("beside and above its position, if no point is there", () => {
  expect(labelPlace(label, middle, ends(120, 10), letter)).toEqual({
    x: 109,
    y: 92.8,
    anchor: "start",
  });
  expect(labelPlace(label, middle, [middle], letter).anchor).toBe("start");
});

it("covers no end of a distance, however long and in whatever direction", () => {
  for (let length = 4; length < 90; length += 3) {
    for (let degrees = 0; degrees < 360; degrees += 5) {
      const angle = (degrees * Math.PI) / 180;
      const points = ends(length * Math.cos(angle), length * Math.sin(angle));
      const place = labelPlace(label, middle, points, letter);
      expect([length, degrees, points.some((point) => isCovered(point, place))]).toEqual([
        length,
        degrees,
        false,
      ]);
    }
  }
});

it("is above all points, if these are everywhere", () => {
  const points = Array.from({ length: 400 }, (_, i) => ({
    x: 5 * (i % 40),
    y: 50 + 10 * Math.floor(i / 40),
  }));
  const place = labelPlace(label, middle, points, letter);
  expect(points.some((point) => isCovered(point, place))).toBe(false);
});
