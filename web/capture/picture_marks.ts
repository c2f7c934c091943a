import type { StoreInfo, Triple } from "../core/types.ts";
import { labelPlace } from "../measure/label_place.ts";
import { labelPoint, type Measurement } from "../measure/measurement.ts";
import { axisColours, axisNames } from "../overlay/axis_names.ts";
import { unitOf } from "../overlay/length_unit.ts";
import { formatLength, scaleBar } from "../overlay/lengths.ts";
import type { Screen, ScreenPoint } from "../overlay/screen.ts";
import type { PictureSize } from "../viewer/types.ts";
import { MarkPen, round } from "./mark_pen.ts";

/** What a saved picture shows above the volume. */
export interface PictureMarks {
  title?: string;
  /**
   * `ends`: the texts at the first and the last colour; `ticks`: of contour lines, from 0 at the first colour to 1 at
   * the last one; `notes`: lines of text below.
   */
  legend?: {
    name: string;
    colours: readonly string[];
    ends: readonly [string, string];
    ticks?: readonly { at: number; isDark: boolean }[];
    notes?: readonly string[];
    /** In place of colours and ends: lines of text, each with a colour beside it. */
    labels?: readonly { text: string; colour?: string }[];
  };
  hasScale?: boolean;
  hasAxes?: boolean;
  measurements?: readonly { measurement: Measurement; label: string }[];
}

/** The view that the marks belong to. */
export interface MarkedView {
  size: PictureSize;
  screen: Screen;
  info: StoreInfo;
  /** The point at whose distance the scale bar is exact. */
  target: Triple;
  /** #rrggbb, or undefined for none. */
  background: string | undefined;
}

/** Share of the picture's shorter side that a letter takes, and the fewest pixels. */
const letterShare = 1 / 36;
const smallestLetter = 11;

/**
 * The marks as elements of an SVG document whose unit is a pixel of the picture: the title at the top left, the
 * legend at the top right, the scale bar at the bottom left, the axes at the bottom right.
 */
export function marksSvg(marks: PictureMarks, view: MarkedView): string {
  const { width, height } = view.size;
  const pen = new MarkPen(
    Math.max(smallestLetter, letterShare * Math.min(width, height)),
    view.background,
  );
  const { letter } = pen;
  const parts = [
    ...(marks.measurements ?? []).map((each) => measurementMark(each, view.screen, pen)),
    marks.title ? pen.text(marks.title, letter, 1.8 * letter, { size: 1.2 }) : "",
    marks.legend ? legendMark(marks.legend, width, pen) : "",
    marks.hasScale ? scaleMark(view, pen) : "",
    marks.hasAxes ? axesMark(view, pen) : "",
  ];
  return `<g font-family="sans-serif" fill="${pen.ink}">${parts.join("")}</g>`;
}

function scaleMark({ size, screen, info, target }: MarkedView, pen: MarkPen): string {
  const { letter } = pen;
  const bar = scaleBar(screen.pixelsPerUnit(target), 0.25 * size.width);
  if (!bar) return "";
  const [x, y] = [letter, size.height - letter];
  const [top, end] = [round(y - 0.4 * letter), round(x + bar.pixels)];
  const length = formatLength(bar.mm, unitOf(info));
  const line = pen.line(`M${round(x)} ${top}V${round(y)}H${end}V${top}`);
  return line + pen.text(length, x + bar.pixels / 2, y - 0.7 * letter, { anchor: "middle" });
}

/** The world's axes. Those that point to the eye are drawn last. */
function axesMark({ size, screen, info }: MarkedView, pen: MarkPen): string {
  const { letter } = pen;
  const length = 2.4 * letter;
  const centre = { x: size.width - length - 1.6 * letter, y: size.height - length - 1.6 * letter };
  const names = axisNames(info);
  const ends = [0, 1, 2].map((axis) => {
    const world: Triple = [0, 0, 0];
    world[axis] = 1;
    const { right, down, away } = screen.direction(world);
    const [x, y] = [centre.x + length * right, centre.y + length * down];
    const path = `M${round(centre.x)} ${round(centre.y)}L${round(x)} ${round(y)}`;
    const line = `<path d="${path}" stroke="${axisColours[axis]}" stroke-width="${round(0.16 * letter)}" stroke-linecap="round"/>`;
    const at = { x: x + 0.8 * letter * right, y: y + 0.8 * letter * down + 0.35 * letter };
    return { away, svg: line + pen.text(names[axis]?.[1] ?? "", at.x, at.y, { anchor: "middle" }) };
  });
  return ends
    .sort((a, b) => b.away - a.away)
    .map(({ svg }) => svg)
    .join("");
}

function legendMark(
  {
    name,
    colours,
    ends: [low, high],
    ticks = [],
    notes = [],
    labels,
  }: NonNullable<PictureMarks["legend"]>,
  width: number,
  pen: MarkPen,
): string {
  const { letter } = pen;
  if (labels) return labelsMark(name, labels, notes, width, pen);
  const length = Math.min(12 * letter, 0.4 * width);
  const x = width - letter - length;
  const share = (i: number) => round(i / Math.max(1, colours.length - 1));
  const stops = colours.map((colour, i) => `<stop offset="${share(i)}" stop-color="${colour}"/>`);
  const bar = `<rect x="${round(x)}" y="${round(2 * letter)}" width="${round(length)}" height="${round(0.7 * letter)}" fill="url(#legend)" stroke="${pen.halo}" stroke-width="${round(0.08 * letter)}"/>`;
  return [
    `<linearGradient id="legend">${stops.join("")}</linearGradient>`,
    pen.text(name, x + length, 1.6 * letter, { anchor: "end" }),
    bar,
    ...ticks.map(({ at, isDark }) => {
      const [place, top] = [round(x + at * length), round(2 * letter)];
      return `<path d="M${place} ${top}v${round(0.7 * letter)}" stroke="${isDark ? "#000" : "#fff"}" stroke-width="${round(0.08 * letter)}"/>`;
    }),
    pen.text(low, x, 3.8 * letter, { size: 0.85 }),
    pen.text(high, x + length, 3.8 * letter, { size: 0.85, anchor: "end" }),
    ...notes.map((note, i) =>
      pen.text(note, x + length, (5 + 1.2 * i) * letter, { size: 0.85, anchor: "end" }),
    ),
  ].join("");
}

/** A legend of labels, whose colours are at the right border. */
function labelsMark(
  name: string,
  labels: readonly { text: string; colour?: string }[],
  notes: readonly string[],
  width: number,
  pen: MarkPen,
): string {
  const { letter } = pen;
  const x = width - letter;
  const lineAt = (i: number): number => (3 + 1.2 * i) * letter;
  return [
    pen.text(name, x, 1.6 * letter, { anchor: "end" }),
    ...labels.map(({ text, colour }, i) => {
      const side = round(0.7 * letter);
      const box = colour
        ? `<rect x="${round(x - 0.7 * letter)}" y="${round(lineAt(i) - 0.65 * letter)}" width="${side}" height="${side}" fill="${colour}" stroke="${pen.halo}" stroke-width="${round(0.08 * letter)}"/>`
        : "";
      return box + pen.text(text, x - letter, lineAt(i), { size: 0.85, anchor: "end" });
    }),
    ...notes.map((note, i) =>
      pen.text(note, x, lineAt(labels.length + i), { size: 0.85, anchor: "end" }),
    ),
  ].join("");
}

function measurementMark(
  { measurement, label }: { measurement: Measurement; label: string },
  screen: Screen,
  pen: MarkPen,
): string {
  const { letter } = pen;
  const seen = measurement.points.map(({ position }) => screen.point(position));
  const points = seen.filter((point): point is ScreenPoint => point !== undefined);
  const path = points.map(({ x, y }, i) => `${i === 0 ? "M" : "L"}${round(x)} ${round(y)}`);
  const line = points.length === seen.length && points.length > 1 ? pen.line(path.join("")) : "";
  const circles = points.map(
    ({ x, y }) =>
      `<circle cx="${round(x)}" cy="${round(y)}" r="${round(0.28 * letter)}" fill="${pen.halo}" stroke="${pen.ink}" stroke-width="${round(0.12 * letter)}"/>`,
  );
  const position = labelPoint(measurement);
  const at = position && screen.point(position);
  const marks = line + circles.join("");
  if (!at) return marks;
  const { x, y, anchor } = labelPlace(label, at, points, letter);
  return marks + pen.text(label, x, y, { anchor });
}
