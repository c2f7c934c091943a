// The overlays above the picture, and the views along the axes.

import { describe, expect, it } from "vitest";
import { roundBelow } from "../../web/core/round_below.ts";
import { axisNames } from "../../web/overlay/axis_names.ts";
import { boundingBox } from "../../web/overlay/bounding_box.ts";
import {
  clipEdges,
  clipFaces,
  draggedShare,
  faceOnScreen,
  movedFace,
  shareAfterKey,
} from "../../web/overlay/clip_faces.ts";
import {
  formatLength,
  formatMeasured,
  formatPower,
  formatVolume,
  roundedToVoxel,
  scaleBar,
  ticks,
} from "../../web/overlay/lengths.ts";
import { Screen } from "../../web/overlay/screen.ts";
import type { StoreInfo } from "../../web/stream/index.ts";
import { axisViews, cameraAlong, cameraBetween } from "../../web/viewer/camera_views.ts";
import type { Camera, Clip } from "../../web/viewer/types.ts";

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

describe("the clip box", () => {
  // A sheared grid that is not at the origin: 20 × 10 × 8 mm.
  const info = {
    voxels: [21, 6, 5],
    spacing: [1, 2, 2],
    origin: [-9, -3, -4],
    direction: [1, 0.25, 0, 0, 1, 0.25, 0, 0, 1],
  } as unknown as StoreInfo;
  const clip: Clip = { low: [0.2, 0.1, 0.25], high: [0.9, 0.8, 1], planes: [] };
  const perspective = lookingAlongY(400, 300);
  const orthographic = new Screen(
    [0.02, 0.003, 0.01, 0, 0.008, 0.01, -0.02, 0, -0.01, 0.04, 0.002, 0, 0.1, 0.2, 0, 1],
    400,
    300,
  );

  it.each([
    ["perspective", perspective],
    ["orthographic", orthographic],
  ])("has faces that follow the pointer: %s", (_, screen) => {
    for (const face of clipFaces) {
      const before = faceOnScreen(info, screen, clip, face);
      const share = clip[face.end][face.axis] + (face.end === "low" ? 0.15 : -0.15);
      const after = faceOnScreen(info, screen, movedFace(clip, face, share), face);
      if (!before || !after) throw new Error("not in front of the eye");
      const moved = { right: after.x - before.x, down: after.y - before.y };
      // An axis that is seen end-on moves less.
      if (Math.hypot(moved.right, moved.down) < 20) continue;
      expect(draggedShare(info, screen, clip, face, moved)).toBeCloseTo(share, 2);
      // Movement across the axis does not count.
      const across = { right: moved.right - 3 * moved.down, down: moved.down + 3 * moved.right };
      expect(draggedShare(info, screen, clip, face, across)).toBeCloseTo(share, 2);
    }
    const isBehind = clipFaces
      .slice(2, 4)
      .map((y) => faceOnScreen(info, screen, clip, y)?.isBehind);
    expect(isBehind).toEqual(screen === perspective ? [false, true] : [true, false]);
  });

  it("has a limited speed along an axis that is seen end on", () => {
    const axis = { ...info, direction: [1, 0, 0, 0, 1, 0, 0, 0, 1] } as StoreInfo;
    const face = { axis: 1, end: "low" } as const;
    const step = draggedShare(axis, perspective, clip, face, { right: 8, down: 0 }) - 0.1;
    expect(Math.abs(step)).toBeLessThanOrEqual(0.1);
    // Beyond the vanishing point, the movement is limited.
    for (const right of [-1e6, 1e6]) {
      const share = draggedShare(info, perspective, clip, face, { right, down: 0 });
      expect(Number.isFinite(share)).toBe(true);
      const { low } = movedFace(clip, face, share);
      expect(low[1]).toBeGreaterThanOrEqual(0);
      expect(low[1]).toBeLessThanOrEqual(0.79);
    }
  });

  it("is never empty, and keeps the faces that do not move", () => {
    const planes = [{ normal: [0, 0, 1] as const, offset: 2 }] as unknown as Clip["planes"];
    const cut = { ...clip, planes };
    expect(movedFace(cut, { axis: 0, end: "low" }, 5)).toEqual({ ...cut, low: [0.89, 0.1, 0.25] });
    expect(movedFace(cut, { axis: 2, end: "high" }, -1)).toEqual({
      ...cut,
      high: [0.9, 0.8, 0.26],
    });
    expect(movedFace(cut, { axis: 1, end: "high" }, 7)).toEqual({ ...cut, high: [0.9, 1, 1] });
    expect(cut.low).toEqual([0.2, 0.1, 0.25]);
  });

  it("moves by keys like a slider", () => {
    expect(shareAfterKey("ArrowRight", 0.5, false)).toBeCloseTo(0.51);
    expect(shareAfterKey("ArrowDown", 0.5, true)).toBeCloseTo(0.4);
    expect(shareAfterKey("PageUp", 0.5, false)).toBeCloseTo(0.6);
    expect(shareAfterKey("Home", 0.5, false)).toBe(0);
    expect(shareAfterKey("a", 0.5, false)).toBeUndefined();
  });

  it("has twelve edges, and fewer if it reaches behind the eye", () => {
    expect(clipEdges(info, perspective, clip)).toHaveLength(12);
    const near = { ...info, origin: [-9, -12, -4] } as unknown as StoreInfo;
    const edges = clipEdges(near, perspective, clip);
    expect(edges.length).toBeLessThan(12);
    for (const { from, to } of edges) expect(Math.min(from.depth, to.depth)).toBeGreaterThan(0);
  });
});

describe("lengths", () => {
  it("have areas and volumes in the units of lengths", () => {
    expect(formatPower(1234567.8, 2)).toBe("1.23457 m²");
    expect(formatPower(123456, 2)).toBe("123456 mm²");
    expect(formatPower(1.2e-7, 2)).toBe("120000 nm²");
    expect(formatPower(5e-10, 3)).toBe("500000000 nm³");
    expect(formatPower(0, 3)).toBe("0 mm³");
    expect(formatVolume(1_482_345)).toBe("1,482 cm³");
    expect(formatVolume(1953.125)).toBe("1.953 cm³");
    expect(formatVolume(999)).toBe("999 mm³");
    expect(formatVolume(0.25)).toBe("0.25 mm³");
    expect(formatVolume(2.5e9)).toBe("2.5 m³");
    expect(formatVolume(1e-6)).toBe("1,000 µm³");
    expect(formatVolume(0)).toBe("0 mm³");
  });

  it("rounds what was measured to a tenth of a voxel, and nothing where voxels are unknown", () => {
    const measured = (mm: number, voxelMm: number) => formatMeasured(mm, voxelMm);
    expect(measured(56.4942, 1)).toBe("56.5 mm");
    expect(measured(56.4942, 0.33)).toBe("56.49 mm");
    expect(measured(0.0123456, 2e-4)).toBe("12.35 µm");
    expect(measured(1234.5678, 25)).toBe("1.235 m");
    expect(measured(56.4942, Infinity)).toBe("56.4942 mm");
    expect(measured(56.4942, 0)).toBe("56.4942 mm");
    expect(roundedToVoxel(-60.0903, 1)).toBeCloseTo(-60.1, 9);
    expect(roundedToVoxel(60.0903, Infinity)).toBe(60.0903);
  });

  it("have a unit that suits their size", () => {
    expect([25, 0.05, 1500, 2e-5, 0, 7.25].map((mm) => formatLength(mm))).toEqual([
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

  it("make a bar between a third of the maximum length and the maximum", () => {
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
  it("are anatomical if the format has patient coordinates", () => {
    expect(axisNames(info)[0]).toEqual(["R", "L"]);
    const raw = { ...info, metadata: { source: { format: "raw" } } } as unknown as StoreInfo;
    expect(axisNames(raw)[2]).toEqual(["−z", "z"]);
  });

  it("are x, y and z if a note states that left and right may be swapped", () => {
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

  it("are reached by the shorter rotation", () => {
    const to = { ...camera, azimuth: -170, distance: 2, roll: 0 };
    const half = cameraBetween(camera, to, 0.5);
    expect(half.azimuth).toBe(180);
    expect(half.distance).toBeCloseTo(4);
    expect(half.roll).toBe(15);
    expect(cameraBetween(camera, to, 0)).toEqual({ ...camera, azimuth: 170 });
    expect(cameraBetween(camera, to, 1)).toBe(to);
  });
});
