/** A position on the screen or in a picture; y points down. */
interface Place {
  x: number;
  y: number;
}

/** Where a label is: the position of its baseline, at its start, middle or end. */
export interface LabelPlace extends Place {
  anchor: "start" | "middle" | "end";
}

/** Lengths in heights of a letter: the mean width of letters, and what a label keeps clear around a point. */
const letterWidth = 0.58;
const ascent = 0.8;
const descent = 0.25;
const clearance = 0.55;

/**
 * Where the label of a measurement covers none of its points, nearest to `at`. `letter`: the size of the font.
 * Otherwise a distance of a few centimetres would have its label over its second end.
 */
export function labelPlace(
  label: string,
  at: Place,
  points: readonly Place[],
  letter: number,
): LabelPlace {
  const beside = 0.75 * letter;
  const above = at.y - 0.6 * letter;
  const below = at.y + 1.4 * letter;
  const candidates: LabelPlace[] = [
    { x: at.x + beside, y: above, anchor: "start" },
    { x: at.x, y: at.y - letter, anchor: "middle" },
    { x: at.x - beside, y: above, anchor: "end" },
    { x: at.x + beside, y: below, anchor: "start" },
    { x: at.x - beside, y: below, anchor: "end" },
  ];
  const top = Math.min(at.y, ...points.map(({ y }) => y));
  return (
    candidates.find((place) => !points.some((point) => covers(place, label, point, letter))) ?? {
      x: at.x,
      y: top - letter,
      anchor: "middle",
    }
  );
}

function covers(
  { x, y, anchor }: LabelPlace,
  label: string,
  point: Place,
  letter: number,
): boolean {
  const width = letterWidth * letter * label.length;
  const left = anchor === "start" ? x : anchor === "end" ? x - width : x - width / 2;
  const across = Math.max(left - point.x, point.x - left - width, 0);
  const along = Math.max(y - ascent * letter - point.y, point.y - y - descent * letter, 0);
  return Math.hypot(across, along) < clearance * letter;
}
