import type { Light } from "./light.ts";

/** How viewer, address and panel treat one of the numbers of Light. */
export interface LightSetting {
  /** The default. */
  first: number;
  range: readonly [number, number];
  /** The step of the panel's sliders and keys. */
  step: number;
  /**
   * The parameter of the page's address that contains it, after the numbers of this parameter
   * above.
   */
  parameter: string;
}

/** The light's numbers, in the order of the panel's sliders. */
export const lightSettings: Readonly<Record<keyof Light, LightSetting>> = {
  azimuth: { first: -45, range: [-180, 180], step: 5, parameter: "light" },
  elevation: { first: 45, range: [-90, 90], step: 5, parameter: "light" },
  key: { first: 1, range: [0, 2], step: 0.05, parameter: "light-strength" },
  sky: { first: 1, range: [0, 2], step: 0.05, parameter: "light-strength" },
  rim: { first: 0.3, range: [0, 2], step: 0.05, parameter: "light-strength" },
  highlight: { first: 0.6, range: [0, 2], step: 0.05, parameter: "material" },
  roughness: { first: 0.4, range: [0.1, 1], step: 0.05, parameter: "material" },
  occlusion: { first: 1, range: [0, 1], step: 0.05, parameter: "occlusion" },
  occlusionRadius: { first: 0.2, range: [0.001, 1], step: 0.01, parameter: "occlusion" },
  shadow: { first: 0.9, range: [0, 1], step: 0.05, parameter: "shadow" },
  shadowSoftness: { first: 0.1, range: [0.01, 0.5], step: 0.01, parameter: "shadow" },
};

export const lightNames = Object.keys(lightSettings) as (keyof Light)[];
