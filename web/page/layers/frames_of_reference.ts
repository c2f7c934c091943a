import type { StoreInfo, Triple } from "../../core/types.ts";
import { voxelOf } from "../../measure/measurement.ts";
import { layersTexts } from "../../texts/layers.ts";
import { isSameGrid } from "../../viewer/transform.ts";

/** A layer whose store has been read, without a transform. */
export interface PlacedLayer {
  title: string;
  info: StoreInfo;
}

/** The maximum number of layers that a note names. Further ones are counted. */
const mostNamed = 3;

/**
 * Notes about the positions of the layers after the first one. There is a note for a store with another frame of
 * reference than the first layer. Many files do not name their frame: their coordinates alone decide. So there is
 * a note for a store without coordinates whose grid differs from that of the first layer, and for a store that does
 * not overlap the first layer. Stores of one file, such as the labels of a segmentation, have one frame.
 */
export function frameNotes(first: PlacedLayer, others: readonly PlacedLayer[]): string[] {
  const isContradictory = ({ info }: PlacedLayer) => isOfOtherFrame(info, first.info);
  const contradictory = others.filter(isContradictory);
  const different = others.filter(
    (other) =>
      !isContradictory(other) &&
      !isSameGrid(other.info, first.info) &&
      !isOfOneFile(other.info, first.info),
  );
  const unplaced = different.filter(({ info }) => !hasPlace(info));
  const placed = different.filter(({ info }) => hasPlace(info));
  const notes: string[] = [];
  if (contradictory.length > 0) {
    notes.push(layersTexts.otherFrame(named(contradictory), first.title, contradictory.length));
  }
  if (!hasPlace(first.info) && different.length > 0) unplaced.unshift(first);
  if (unplaced.length > 0) notes.push(layersTexts.unplaced(named(unplaced), unplaced.length));
  const apart = (hasPlace(first.info) ? placed : []).filter(
    ({ info }) => !overlaps(boxOf(info), boxOf(first.info)),
  );
  if (apart.length > 0) {
    notes.push(layersTexts.apart(named(apart), first.title, apart.length));
  }
  return notes;
}

/** Whether both stores name their frame of reference, and the frames differ. A frame of DICOM is that of a scanner. */
function isOfOtherFrame(a: StoreInfo, b: StoreInfo): boolean {
  const one = a.metadata.frame_of_reference;
  const other = b.metadata.frame_of_reference;
  if (!one || !other || one === other) return false;
  const frames = [one, other];
  return !(frames.includes("scanner") && frames.some((frame) => frame.startsWith("dicom-")));
}

/**
 * Whether both stores were built from one file: they name the same file, and their voxels lie on one lattice.
 * The name alone is not enough, since many files have the same.
 */
function isOfOneFile(a: StoreInfo, b: StoreInfo): boolean {
  const { file, path_hash: hash } = a.metadata.source ?? {};
  const { file: otherFile, path_hash: otherHash } = b.metadata.source ?? {};
  if (typeof file !== "string" || file !== otherFile || hash !== otherHash) return false;
  const isSame = (one: readonly number[], two: readonly number[]) =>
    one.every((number, i) => Math.abs(number - (two[i] ?? 0)) <= 1e-6 * Math.abs(number));
  if (!isSame(a.spacing, b.spacing) || !isSame(a.direction, b.direction)) return false;
  return voxelOf(a, b.origin).every((each) => Math.abs(each - Math.round(each)) < 1e-3);
}

function named(layers: readonly PlacedLayer[]): string {
  const titles = layers.slice(0, mostNamed).map(({ title }) => title);
  const left = layers.length - titles.length;
  return left > 0 ? layersTexts.andMore(titles.join(", "), left) : titles.join(", ");
}

/**
 * Whether the store states the position of its volume. If a format or a file has no position, the first voxel is at
 * the origin, and the axes are those of the world.
 */
export function hasPlace({ origin, direction, metadata }: StoreInfo): boolean {
  if (metadata.frame_of_reference) return true;
  const isAtOrigin = origin.every((n) => n === 0);
  const isUnturned = direction.every((n, i) => n === (i % 4 === 0 ? 1 : 0));
  return !(isAtOrigin && isUnturned);
}

/** The box along the axes of the world around a grid. */
function boxOf({ voxels, spacing, origin, direction }: StoreInfo): { low: Triple; high: Triple } {
  const low: Triple = [...origin];
  const high: Triple = [...origin];
  for (let axis = 0; axis < 3; ++axis) {
    const length = (spacing[axis] ?? 0) * ((voxels[axis] ?? 1) - 1);
    for (let row = 0; row < 3; ++row) {
      const edge = length * (direction[3 * row + axis] ?? 0);
      if (edge < 0) low[row] = (low[row] ?? 0) + edge;
      else high[row] = (high[row] ?? 0) + edge;
    }
  }
  return { low, high };
}

function overlaps(a: ReturnType<typeof boxOf>, b: ReturnType<typeof boxOf>): boolean {
  return [0, 1, 2].every(
    (i) => (a.low[i] ?? 0) <= (b.high[i] ?? 0) && (b.low[i] ?? 0) <= (a.high[i] ?? 0),
  );
}
