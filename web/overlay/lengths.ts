import { roundBelow } from "../core/round_below.ts";
import { grouped, localized } from "../texts/numbers.ts";
import { overlayTexts } from "../texts/overlay.ts";
import type { LengthUnit } from "./length_unit.ts";

/** Lengths of the world, which are in millimetres, or in voxels whose size is unknown. */

const units = [
  { name: "km", mm: 1e6 },
  { name: "m", mm: 1e3 },
  { name: "cm", mm: 10 },
  { name: "mm", mm: 1 },
  { name: "µm", mm: 1e-3 },
  { name: "nm", mm: 1e-6 },
] as const;

/** 25 → "25 mm"; 0.05 → "50 µm"; in voxels: "25 voxels". Six significant digits at most. */
export function formatLength(mm: number, world: LengthUnit = "mm", texts = overlayTexts): string {
  if (world === "voxel") return texts.voxels(localized(String(Number(mm.toPrecision(6)))));
  const size = Math.abs(mm);
  const unit = units.find((u) => u.name !== "cm" && size >= u.mm) ?? units[units.length - 1];
  if (size === 0 || !unit) return "0 mm";
  return localized(`${Number((mm / unit.mm).toPrecision(6))} ${unit.name}`);
}

/** A measured length or coordinate, rounded to about a tenth of a voxel: 56.4942 mm → 56.5 mm for voxels of 1 mm. */
export function roundedToVoxel(mm: number, voxelMm: number): number {
  const step = 10 ** Math.floor(Math.log10(voxelMm / 10));
  const isKnown = step > 0 && Number.isFinite(step);
  return isKnown ? Math.round(mm / step) * step : mm;
}

/** A measured length, rounded as by `roundedToVoxel`. */
export function formatMeasured(mm: number, voxelMm: number, world: LengthUnit = "mm"): string {
  return formatLength(roundedToVoxel(mm, voxelMm), world);
}

/** An area (power 2) or a volume (3), in mm² or mm³: 0.0005 → "500 µm²"; or in voxels. */
export function formatPower(value: number, power: 2 | 3, world: LengthUnit = "mm"): string {
  const sign = power === 2 ? "²" : "³";
  if (world === "voxel") return `${formatLength(value, world)}${sign}`;
  const size = Math.abs(value);
  const unit =
    units.find((u) => u.name !== "cm" && size >= u.mm ** power) ?? units[units.length - 1];
  if (size === 0 || !unit) return `0 mm${sign}`;
  return localized(`${Number((value / unit.mm ** power).toPrecision(6))} ${unit.name}${sign}`);
}

/** A volume in mm³, with four digits: 1482000 → "1,482 cm³"; 0.5 → "0.5 mm³". */
export function formatVolume(mm3: number): string {
  const least = ({ name, mm }: (typeof units)[number]) => (name === "mm" ? 0.001 : mm ** 3);
  const unit = units.find((each) => mm3 >= least(each)) ?? units[units.length - 1];
  if (mm3 === 0 || !unit) return "0 mm³";
  return `${grouped(Number((mm3 / unit.mm ** 3).toPrecision(4)))} ${unit.name}³`;
}

/** A scale bar of at most `mostPixels`: its length in mm, and in pixels. */
export function scaleBar(
  pixelsPerMm: number,
  mostPixels: number,
): { mm: number; pixels: number } | undefined {
  const most = mostPixels / pixelsPerMm;
  if (!Number.isFinite(most) || most <= 0) return undefined;
  const mm = roundBelow(most);
  return { mm, pixels: mm * pixelsPerMm };
}

/** Multiples of a round step between two lengths, about `count` of them. */
export function ticks(low: number, high: number, count: number): number[] {
  const step = roundBelow((high - low) / count);
  if (!(step > 0) || !Number.isFinite(step)) return [];
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) =>
    Number(((first + i) * step).toPrecision(12)),
  );
}
