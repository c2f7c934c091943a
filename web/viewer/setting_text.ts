import {
  type Camera,
  type Clip,
  type ClipPlane,
  type Projection,
  projections,
  type Slices,
} from "./types.ts";

/**
 * Settings as text: in the page's address, and in the attributes of the element. A reader returns
 * undefined for text that is not valid.
 */

export function readNumbers(text: string | null): number[] | undefined {
  if (text === null || text.trim() === "") return undefined;
  const values = text.split(",").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  return values.every(Number.isFinite) ? values : undefined;
}

export function readColour(text: string | null): string | undefined {
  const match = /^#?([0-9a-f]{6})$/i.exec(text ?? "");
  return match?.[1] ? `#${match[1].toLowerCase()}` : undefined;
}

export function readColours(text: string): string[] | undefined {
  const colours = text.split(",").map(readColour);
  return colours.every((c) => c !== undefined) ? colours : undefined;
}

export function readOpacities(text: string): number[] | undefined {
  const opacities = readNumbers(text);
  return opacities?.every((o) => o >= 0 && o <= 1) ? opacities : undefined;
}

export function readCamera(text: string | null): Camera | undefined {
  const n = readNumbers(text);
  if (!n || n.length < 6 || n.length > 8) return undefined;
  const [azimuth = 0, elevation = 0, distance = 0, x = 0, y = 0, z = 0, roll = 0, view = 30] = n;
  if (!(distance > 0) || Math.abs(elevation) > 90 || !(view >= 1 && view <= 120)) return undefined;
  return { azimuth, elevation, distance, target: [x, y, z], roll, fieldOfView: view };
}

export function readProjection(text: string | null): Projection | undefined {
  return projections.find((projection) => projection === text);
}

/** The box of a Clip. */
export type Box = Pick<Clip, "low" | "high">;

export function readBox(text: string | null): Box | undefined {
  const n = readNumbers(text);
  if (n?.length !== 6 || n.some((value) => value < 0 || value > 1)) return undefined;
  const [x0 = 0, x1 = 1, y0 = 0, y1 = 1, z0 = 0, z1 = 1] = n;
  if (x0 >= x1 || y0 >= y1 || z0 >= z1) return undefined;
  return { low: [x0, y0, z0], high: [x1, y1, z1] };
}

export function readPlane(text: string): ClipPlane | undefined {
  const [x = 0, y = 0, z = 0, offset, ...more] = readNumbers(text) ?? [];
  if (offset === undefined || more.length > 0 || Math.hypot(x, y, z) === 0) return undefined;
  return { normal: [x, y, z], offset };
}

/**
 * The slices across the axes, "0.5,,0.25": for each axis a fraction of the volume's extent, or
 * nothing.
 */
export function readSlices(text: string | null): Slices["along"] | undefined {
  const parts = text?.split(",") ?? [];
  const along = parts.map((part) => (part.trim() === "" ? null : Number(part)));
  const isValid = along.length === 3 && along.every((n) => n === null || (n >= 0 && n <= 1));
  return isValid && along.some((n) => n !== null)
    ? (along as unknown as Slices["along"])
    : undefined;
}

export function writeSlices(along: Slices["along"]): string | undefined {
  return along.some((n) => n !== null) ? along.map((n) => n ?? "").join(",") : undefined;
}

/** Writes a camera as `azimuth,elevation,distance,x,y,z[,roll[,field of view]]`, which readCamera reads. */
export function writeCamera(camera: Camera): string {
  const { azimuth, elevation, distance, target, roll, fieldOfView } = camera;
  const numbers = [azimuth, elevation, distance, ...target];
  if (roll !== 0 || fieldOfView !== 30) numbers.push(roll);
  if (fieldOfView !== 30) numbers.push(fieldOfView);
  return numbers.join(",");
}
