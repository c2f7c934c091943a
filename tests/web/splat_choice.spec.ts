import { expect, it } from "vitest";
import { SplatChoice } from "../../web/viewer/splat_choice.ts";
import type { SplatKind } from "../../web/viewer/types.ts";

const frame = (kind: SplatKind, programsLinked = 0) => ({ kind, programsLinked });

it("draws ellipses in motion and the exact surface at rest, on a GPU that can", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse"), 8, 100);
  expect(choice.kind(false, 100)).toBe("ellipse");
  expect(choice.kind(true, 100)).toBe("exact");
});

it("falls back to squares in motion, and returns when they are fast", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse"), 90, 100);
  expect(choice.kind(false, 100)).toBe("quad");
  choice.measured(frame("quad"), 30, 100);
  expect(choice.kind(false, 100)).toBe("quad");
  choice.measured(frame("quad"), 5, 100);
  expect(choice.kind(false, 100)).toBe("ellipse");
});

it("does not repeat an exact picture that took too long, until the view is another", () => {
  const choice = new SplatChoice();
  choice.measured(frame("exact"), 4000, 100);
  expect(choice.kind(true, 100)).toBe("ellipse");
  expect(choice.kind(true, 110)).toBe("ellipse");
  expect(choice.kind(true, 300)).toBe("exact");
  expect(choice.kind(true, 100)).toBe("exact");
});

it("does not try the exact picture where motion is hopeless already", () => {
  const choice = new SplatChoice();
  choice.measured(frame("quad"), 900, 100);
  expect(choice.kind(true, 100)).toBe("ellipse");
});

it("does not judge by frames that had to link programs", () => {
  const choice = new SplatChoice();
  choice.measured(frame("ellipse", 1), 900, 100);
  expect(choice.kind(false, 100)).toBe("ellipse");
  expect(choice.kind(true, 100)).toBe("exact");
  choice.measured(frame("exact", 2), 4000, 100);
  expect(choice.kind(true, 100)).toBe("exact");
});
