import { describe, expect, it } from "vitest";
import {
  defaultLight,
  type Light,
  lightFromDisc,
  lightOnDisc,
  lightRanges,
  turnedLight,
} from "../../web/viewer/light.ts";

describe("the disc that shows the key light's direction", () => {
  const light = (azimuth: number, elevation: number): Light => ({
    ...defaultLight,
    azimuth,
    elevation,
  });

  it("has the light from the eye in its middle, and the light from above left at the upper left", () => {
    expect(lightOnDisc(light(0, 0))).toEqual({ x: 0, y: 0 });
    const { x, y } = lightOnDisc(defaultLight);
    expect(x).toBeLessThan(-0.3);
    expect(y).toBeGreaterThan(0.3);
  });

  it("maps each direction in front of the surface to a point and back", () => {
    for (const azimuth of [-85, -40, 0, 10, 90]) {
      for (const elevation of [-80, -30, 0, 45]) {
        const { x, y } = lightOnDisc(light(azimuth, elevation));
        const back = lightFromDisc(x, y);
        expect(Math.abs(back.azimuth - azimuth)).toBeLessThanOrEqual(1);
        expect(Math.abs(back.elevation - elevation)).toBeLessThanOrEqual(1);
      }
    }
  });

  it("moves points beyond its edge, and directions behind the surface, to its edge", () => {
    expect(lightFromDisc(5, 0)).toEqual({ azimuth: 90, elevation: 0 });
    expect(lightFromDisc(0, -3)).toEqual({ azimuth: 0, elevation: -90 });
    const { x, y } = lightOnDisc(light(150, 20));
    expect(Math.hypot(x, y)).toBeCloseTo(1);
  });

  it("stops turning at the side of the surface", () => {
    const turned = turnedLight(light(60, 80), 50, 20);
    expect([turned.azimuth, turned.elevation]).toEqual([90, 90]);
  });

  it("starts within the ranges", () => {
    for (const name of Object.keys(defaultLight) as (keyof Light)[]) {
      const [low, high] = lightRanges[name];
      expect(defaultLight[name]).toBeGreaterThanOrEqual(low);
      expect(defaultLight[name]).toBeLessThanOrEqual(high);
    }
  });
});
