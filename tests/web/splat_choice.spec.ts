import { expect, it } from "vitest";
import { SplatChoice } from "../../web/viewer/splat_choice.ts";

it("draws ellipses in motion and the exact surface at rest, on a GPU that can", () => {
  const choice = new SplatChoice();
  choice.measured("ellipse", 8, 100);
  expect(choice.kind(false, 100)).toBe("ellipse");
  expect(choice.kind(true, 100)).toBe("exact");
});

it("falls back to squares in motion, and returns when they are fast", () => {
  const choice = new SplatChoice();
  choice.measured("ellipse", 90, 100);
  expect(choice.kind(false, 100)).toBe("quad");
  choice.measured("quad", 30, 100);
  expect(choice.kind(false, 100)).toBe("quad");
  choice.measured("quad", 5, 100);
  expect(choice.kind(false, 100)).toBe("ellipse");
});

it("does not repeat an exact picture that took too long, until the view is another", () => {
  const choice = new SplatChoice();
  choice.measured("exact", 4000, 100);
  expect(choice.kind(true, 100)).toBe("ellipse");
  expect(choice.kind(true, 110)).toBe("ellipse");
  expect(choice.kind(true, 300)).toBe("exact");
  expect(choice.kind(true, 100)).toBe("exact");
});

it("does not try the exact picture where motion is hopeless already", () => {
  const choice = new SplatChoice();
  choice.measured("quad", 900, 100);
  expect(choice.kind(true, 100)).toBe("ellipse");
});
