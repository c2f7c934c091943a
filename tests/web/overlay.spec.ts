// What lies above the picture, and the views along the axes.
import { describe, expect, it } from "vitest";
import { axisNames } from "../../web/overlay/axis_names.ts";
import { boundingBox } from "../../web/overlay/bounding_box.ts";
import {
  formatLength,
  formatPower,
  roundBelow,
  scaleBar,
  ticks,
} from "../../web/overlay/lengths.ts";
import { Screen } from "../../web/overlay/screen.ts";
import type { StoreInfo } from "../../web/stream/index.ts";
import { axisViews, cameraAlong, cameraBetween } from "../../web/viewer/camera_views.ts";
import type { Camera } from "../../web/viewer/types.ts";

/** A camera at (0, −10, 0) that looks along y, with a field of view of 90°: column by column. */
function lookingAlongY(width: number, height: number): Screen {
  const right = [height / width, 0, 0];
  const up = [0, 0, 1];
  const forward = [0, 1, 0];
  const columns = [0, 1, 2].flatMap((i) => [right[i], up[i], forward[i], forward[i]] as number[]);
  return new Screen([...columns, 0, 0, 9, 10], width, height);
}

describe("points of the world in a picture", () => {
  const screen = lookingAlongY(400, 200);

  it("are where the camera sees them", () => {
    expect(screen.point([0, 0, 0])).toEqual({ x: 200, y: 100, depth: 10 });
    // 45° upwards and to the right: the upper edge, and the same distance to the right.
    expect(screen.point([10, 0, 10])).toEqual({ x: 300, y: 0, depth: 10 });
    expect(screen.point([0, -20, 0])).toBeUndefined();
  });

  it("have directions of the length that they have in the world", () => {
    expect(screen.direction([1, 0, 0])).toEqual({ right: 1, down: -0, away: 0 });
    expect(screen.direction([0, 0, 1])).toEqual({ right: 0, down: -1, away: 0 });
    expect(screen.direction([0, 1, 0]).away).toBe(1);
  });

  it("have a scale at their depth", () => {
    // 20 units are as high as the picture at a distance of 10.
    expect(screen.pixelsPerUnit([3, 0, 5])).toBe(10);
    expect(screen.pixelsPerUnit([0, 10, 0])).toBe(5);
  });
});

describe("lengths", () => {
  it("have areas and volumes in the units of lengths", () => {
    expect(formatPower(1234567.8, 2)).toBe("1.23457 m²");
    expect(formatPower(123456, 2)).toBe("123456 mm²");
    expect(formatPower(1.2e-7, 2)).toBe("120000 nm²");
    expect(formatPower(5e-10, 3)).toBe("500000000 nm³");
    expect(formatPower(0, 3)).toBe("0 mm³");
  });

  it("have the unit that fits them", () => {
    expect([25, 0.05, 1500, 2e-5, 0, 7.25].map(formatLength)).toEqual([
      "25 mm",
      "50 µm",
      "1.5 m",
      "20 nm",
      "0 mm",
      "7.25 mm",
    ]);
  });

  it("are rounded down to 1, 2 or 5", () => {
    expect([1, 1.9, 2, 4.99, 5, 9.9, 0.03, 700].map(roundBelow)).toEqual([
      1, 1, 2, 2, 5, 5, 0.02, 500,
    ]);
  });

  it("make a bar that is no longer than it may be, and more than a third of that", () => {
    for (const scale of [0.013, 0.5, 1, 3, 17, 4000]) {
      const bar = scaleBar(scale, 140);
      expect(bar?.pixels).toBeLessThanOrEqual(140);
      expect(bar?.pixels).toBeGreaterThan(140 / 2.51);
      expect(bar && bar.mm * scale).toBeCloseTo(bar?.pixels ?? 0);
    }
    expect(scaleBar(0, 140)).toBeUndefined();
  });

  it("have ticks at round numbers", () => {
    expect(ticks(0, 127, 5)).toEqual([0, 20, 40, 60, 80, 100, 120]);
    expect(ticks(0, 0.3, 3)).toEqual([0, 0.1, 0.2, 0.3]);
    expect(ticks(0, 0, 3)).toEqual([]);
  });
});

const info = {
  voxels: [11, 11, 11],
  spacing: [1, 1, 1],
  origin: [-5, -5, -5],
  direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  metadata: { source: { format: "NIfTI" } },
} as unknown as StoreInfo;

describe("the box of the volume", () => {
  it("has twelve edges, three of them behind the volume, and ticks along three", () => {
    const box = boundingBox(info, lookingAlongY(800, 800));
    expect(box?.edges.length).toBe(12);
    expect(box?.edges.filter(({ isBehind }) => isBehind).length).toBe(3);
    const lengths = box?.ticks.map(({ length }) => length) ?? [];
    expect(Math.min(...lengths)).toBe(0);
    expect(Math.max(...lengths)).toBe(10);
    // Labels are outside of the box.
    for (const { at, outwards } of box?.ticks ?? []) {
      const towards = (at.x - 400) * outwards.x + (at.y - 400) * outwards.y;
      expect(towards).toBeGreaterThanOrEqual(0);
    }
  });

  it("is not shown if a corner is beside the eye or behind it", () => {
    expect(
      boundingBox({ ...info, origin: [-5, -12, -5] }, lookingAlongY(400, 400)),
    ).toBeUndefined();
  });
});

describe("the names of the axes", () => {
  it("are those of a patient if the format has patient coordinates", () => {
    expect(axisNames(info)[0]).toEqual(["R", "L"]);
    const raw = { ...info, metadata: { source: { format: "raw" } } } as unknown as StoreInfo;
    expect(axisNames(raw)[2]).toEqual(["−z", "z"]);
  });

  it("are x, y and z if a note of the import doubts the sides", () => {
    const noted = (note: string) => ({
      ...info,
      metadata: { ...info.metadata, notes: [note] },
    });
    const swapped = "the sform is used; left and right may be swapped";
    expect(axisNames(noted(swapped))[0]).toEqual(["−x", "x"]);
    expect(axisNames(noted("the header's sform is singular"))[0]).toEqual(["R", "L"]);
  });
});

describe("views along the axes", () => {
  const camera: Camera = {
    target: [1, 2, 3],
    distance: 8,
    azimuth: 170,
    elevation: 20,
    roll: 30,
    fieldOfView: 30,
  };

  it("are six, without roll, around the same point", () => {
    const ends = axisViews.map(({ axis, side }) => side * (axis + 1)).sort((a, b) => a - b);
    expect(ends).toEqual([-3, -2, -1, 1, 2, 3]);
    const left = axisViews.find(({ axis, side }) => axis === 0 && side === 1);
    const seen = left && cameraAlong(camera, left);
    expect(seen).toEqual({ ...camera, azimuth: 90, elevation: 0, roll: 0 });
  });

  it("are reached the shorter way round", () => {
    const to = { ...camera, azimuth: -170, distance: 2, roll: 0 };
    const half = cameraBetween(camera, to, 0.5);
    expect(half.azimuth).toBe(180);
    expect(half.distance).toBeCloseTo(4);
    expect(half.roll).toBe(15);
    expect(cameraBetween(camera, to, 0)).toEqual({ ...camera, azimuth: 170 });
    expect(cameraBetween(camera, to, 1)).toBe(to);
  });
});
