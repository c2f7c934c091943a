import { type LightSetting, lightSettings } from "./light_settings.ts";

/**
 * The light on the surfaces, and their material: the numbers of shared/render/settings/light.h. The
 * key light is fixed in the camera's frame.
 */
export interface Light {
  /** Of the key light: degrees, −180 … 180; 0: from the eye, negative: from the left. */
  azimuth: number;
  /** Of the key light: degrees, −90 … 90; positive: from above. */
  elevation: number;
  /** Strength of the key light, 0 … 2. */
  key: number;
  /** Strength of the light from all sides, 0 … 2. */
  sky: number;
  /** Strength of the light from behind, 0 … 2. */
  rim: number;
  /** Strength of highlights, 0 … 2. There are none where colours represent values. */
  highlight: number;
  /** 0.1 … 1. A high roughness gives wide and faint highlights. */
  roughness: number;
  /** Strength of ambient occlusion, 0 … 1. It appears when the view rests. */
  occlusion: number;
  /** The maximum distance of occluders, as a fraction of the visible volume's radius, 0.001 … 1. */
  occlusionRadius: number;
  /** Strength of shadows, 0 … 1. They appear when the view rests. */
  shadow: number;
  /** Radius of the key light at distance 1, 0.01 … 0.5. */
  shadowSoftness: number;
}

/** The defaults of LightSettings. */
export const defaultLight = ofEach(({ first }) => first) as unknown as Light;

/** The ranges in which the renderer uses these numbers. */
export const lightRanges = ofEach(({ range }) => range) as Readonly<
  Record<keyof Light, readonly [number, number]>
>;

function ofEach<Value>(value: (setting: LightSetting) => Value): Record<string, Value> {
  return Object.fromEntries(
    Object.entries(lightSettings).map(([name, setting]) => [name, value(setting)]),
  );
}

const degrees = 180 / Math.PI;

/**
 * The key light's direction as a point on a disc: x to the right, y up. The centre is a light from
 * the eye; the edge, and points beyond it, are lights from the side. Lights behind the surface lie
 * on the edge.
 */
export function lightOnDisc({ azimuth, elevation }: Light): { x: number; y: number } {
  const y = Math.sin(elevation / degrees);
  const x = Math.sin(azimuth / degrees) * Math.cos(elevation / degrees);
  if (Math.abs(azimuth) <= 90) return { x, y };
  const length = Math.hypot(x, y) || 1;
  return { x: x / length, y: y / length };
}

/**
 * The angles of the key light for a point on the disc. Points beyond its edge are moved to the
 * edge.
 */
export function lightFromDisc(x: number, y: number): Pick<Light, "azimuth" | "elevation"> {
  const scale = 1 / Math.max(1, Math.hypot(x, y));
  const up = Math.max(-1, Math.min(1, y * scale));
  const towardsEye = Math.sqrt(Math.max(0, 1 - (x * scale) ** 2 - up ** 2));
  return {
    azimuth: Math.round(Math.atan2(x * scale, towardsEye) * degrees),
    elevation: Math.round(Math.asin(up) * degrees),
  };
}

/** Turns the key light by these angles. It stays in front of the surface. */
export function turnedLight(light: Light, right: number, up: number): Light {
  const within = (value: number) => Math.max(-90, Math.min(90, value));
  return {
    ...light,
    azimuth: within(light.azimuth + right),
    elevation: within(light.elevation + up),
  };
}
