import type { VolumeDescription, VoxelType } from "../builder/types.ts";
import type { Triple } from "../core/types.ts";

/** Metadata that do not describe a volume. The message states what was expected and found. */
export class ZarrError extends Error {
  override readonly name = "ZarrError";
}

/**
 * An entry of `multiscales` in the metadata of OME-Zarr, 0.1 to 0.5. Its fields are not yet checked.
 */
export interface Multiscale {
  axes?: unknown;
  datasets?: unknown;
  coordinateTransformations?: unknown;
}

export interface Axis {
  name: string;
  unit?: string;
}

const types: Readonly<Record<string, VoxelType>> = {
  uint8: "u8",
  int8: "i8",
  uint16: "u16",
  int16: "i16",
  uint32: "u32",
  int32: "i32",
  uint64: "u64",
  int64: "i64",
  float32: "f32",
  float64: "f64",
};

const millimetres: Readonly<Record<string, number>> = {
  angstrom: 1e-7,
  nanometer: 1e-6,
  micrometer: 1e-3,
  millimeter: 1,
  centimeter: 10,
  decimeter: 100,
  meter: 1000,
  kilometer: 1e6,
  inch: 25.4,
  foot: 304.8,
};

export function voxelType(dataType: string): VoxelType {
  const type = types[dataType];
  if (type) return type;
  throw new ZarrError(
    `expected integers, or floating-point numbers of 32 or 64 bits, found ${dataType}: convert the array`,
  );
}

/** The axes of a multiscale image. In versions 0.1 and 0.2 they are t, c, z, y, x. */
export function imageAxes(multiscale: Multiscale, rank: number): Axis[] {
  const { axes = ["t", "c", "z", "y", "x"].slice(-rank) } = multiscale;
  const named = Array.isArray(axes) ? axes.map(axisOf) : [];
  if (named.length === rank && named.every((axis) => axis !== undefined)) return named;
  throw new ZarrError(
    `expected ${rank} axes with names, as many as the array has, found ${text(axes)}`,
  );
}

function axisOf(value: unknown): Axis | undefined {
  if (typeof value === "string") return { name: value };
  const { name, unit } = (value ?? {}) as { name?: unknown; unit?: unknown };
  if (typeof name !== "string") return undefined;
  return typeof unit === "string" ? { name, unit } : { name };
}

/**
 * The indices of x, y and z among the axes, by their names; without names, the last three, reversed.
 */
export function spatialAxes(axes: readonly Axis[]): Triple {
  const at = (name: string) => axes.findIndex((axis) => axis.name.toLowerCase() === name);
  const named: Triple = [at("x"), at("y"), at("z")];
  if (named.every((axis) => axis >= 0)) return named;
  const names = axes.map(({ name }) => name).join(", ");
  const rank = axes.length;
  if (rank < 3 || named.some((axis) => axis >= 0)) {
    throw new ZarrError(`expected the axes x, y and z, found ${names || "none"}: it is no volume`);
  }
  return [rank - 1, rank - 2, rank - 3];
}

/** Scales and translations of a list of transformations, applied in their order. */
export function placement(
  lists: readonly unknown[],
  rank: number,
): { scale: number[]; translation: number[] } {
  const scale: number[] = Array(rank).fill(1);
  const translation: number[] = Array(rank).fill(0);
  for (const step of lists.flatMap((list) => (Array.isArray(list) ? list : []))) {
    const { type } = (step ?? {}) as { type?: unknown };
    if (type !== "scale" && type !== "translation") continue;
    const numbers = (step as Record<string, unknown>)[type];
    const isValid =
      Array.isArray(numbers) &&
      numbers.length === rank &&
      numbers.every((n) => Number.isFinite(n) && (type === "translation" || n > 0));
    if (!isValid) {
      const kind = type === "scale" ? "positive numbers" : "numbers";
      throw new ZarrError(`expected ${rank} ${kind} as ${type}, found ${text(numbers)}`);
    }
    numbers.forEach((n: number, axis: number) => {
      if (type === "scale") {
        scale[axis] = (scale[axis] ?? 1) * n;
        translation[axis] = (translation[axis] ?? 0) * n;
      } else translation[axis] = (translation[axis] ?? 0) + n;
    });
  }
  return { scale, translation };
}

/** The grid of a volume in millimetres. Adds assumptions to `notes`. */
export function gridOf(
  axes: readonly Axis[],
  spatial: Triple,
  { scale, translation }: { scale: readonly number[]; translation: readonly number[] },
  notes: string[],
): Required<Pick<VolumeDescription, "spacing" | "origin">> {
  const units = spatial.map((axis) => axes[axis]?.unit);
  const factors = units.map((unit) => millimetres[unit ?? ""]);
  const unknown = units.find((_, i) => factors[i] === undefined);
  if (factors.includes(undefined)) {
    const what =
      unknown === undefined ? "its lengths have no unit" : `its unit ${text(unknown)} is unknown`;
    notes.push(`${what}: millimetres are assumed`);
  }
  const of = (values: readonly number[], i: 0 | 1 | 2) =>
    (values[spatial[i]] ?? 0) * (factors[i] ?? 1);
  return {
    spacing: [of(scale, 0), of(scale, 1), of(scale, 2)],
    origin: [of(translation, 0), of(translation, 1), of(translation, 2)],
  };
}

/** A value of the metadata for a message. */
export function text(value: unknown): string {
  const json = JSON.stringify(value) ?? "nothing";
  return json.length > 80 ? `${json.slice(0, 80)}…` : json;
}
