import { expect, it } from "vitest";
import { SplatChoice } from "../../web/viewer/splat_choice.ts";
import type { Shading, SplatKind } from "../../web/viewer/types.ts";

const frame = (kind: SplatKind, programsLinked = 0, shading: Shading = "exact") => ({
  kind,
  shading,
  programsLinked,
});

it("draws ellipses in motion and the exact surface at rest, on a fast GPU", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse"), 8, 100);
  expect(choice.splats(false, 100).kind).toBe("ellipse");
  expect(choice.splats(true, 100).kind).toBe("exact");
});

it("falls back to squares in motion, and returns when they are fast", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse"), 90, 100);
  expect(choice.splats(false, 100)).toEqual({ kind: "quad", shading: "smooth" });
  choice.measured(frame("quad"), 30, 100);
  expect(choice.splats(false, 100).kind).toBe("quad");
  choice.measured(frame("quad"), 5, 100);
  expect(choice.splats(false, 100).kind).toBe("ellipse");
});

it("does not repeat an exact picture that took too long, until the view is another", () => {
  const choice = new SplatChoice();
  choice.measured(frame("exact"), 4000, 100);
  expect(choice.splats(true, 100).kind).toBe("ellipse");
  expect(choice.splats(true, 110).kind).toBe("ellipse");
  expect(choice.splats(true, 300).kind).toBe("exact");
  expect(choice.splats(true, 100).kind).toBe("exact");
});

it("does not try the exact picture if motion is already too slow", () => {
  const choice = new SplatChoice();
  choice.measured(frame("quad"), 900, 100);
  expect(choice.splats(true, 100).kind).toBe("ellipse");
});

it("ignores the times of frames that had to link programs", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse", 1), 900, 100);
  expect(choice.splats(false, 100).kind).toBe("ellipse");
  expect(choice.splats(true, 100).kind).toBe("exact");
  choice.measured(frame("exact", 2), 4000, 100);
  expect(choice.splats(true, 100).kind).toBe("exact");
});

it("has smooth normals at rest, unless they take too long", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse"), 8, 100);
  expect(choice.splats(false, 100)).toEqual({ kind: "ellipse", shading: "exact" });
  expect(choice.splats(true, 100)).toEqual({ kind: "exact", shading: "smooth" });
  choice.measured(frame("exact", 0, "smooth"), 4000, 100);
  expect(choice.splats(true, 110)).toEqual({ kind: "exact", shading: "exact" });
  expect(choice.splats(true, 300)).toEqual({ kind: "exact", shading: "smooth" });
});
