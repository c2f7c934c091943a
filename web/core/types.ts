/** A store's description of its volume, and decoded data. Values are in the units of the volume. */

export type Triple = [number, number, number];

/** A store's description of its volume. */
export interface StoreInfo {
  /** Voxels along x, y, z. */
  voxels: Triple;
  /** Size of a cell of level 0, in the units of the volume's header. */
  spacing: Triple;
  /** Whether `spacing` is not that of the header: Store.setSpacing. */
  isSpacingGiven?: true;
  /** The spacing of the header, if `spacing` is not. */
  statedSpacing?: Triple;
  /** World position of the centre of voxel (0, 0, 0). */
  origin: Triple;
  /**
   * Row-major; its columns are the axes, of unit length, not always perpendicular:
   * world = origin + direction · (spacing ∘ index).
   */
  direction: number[];
  /** value = offset + scale · quantized value. */
  mapping: { offset: number; scale: number; maxError: number; bits: 8 | 16; hasMissing: boolean };
  /** The smallest and largest value of the volume. */
  range: [number, number];
  /** The same as quantized values. */
  quantizedRange: [number, number];
  /** Levels of detail; level 0 is the volume itself, level `levels − 1` the coarsest. */
  levels: number;
  chunkCount: number;
  missingVoxels: number;
  fileBytes: number;
  /** 32 hex digits: two stores with the same id hold the same content. */
  contentId: string;
  metadata: StoreMetadata;
  /** Further scalars at the voxels of the volume (shared/core/store/FORMAT.md, Fields). */
  fields: readonly FieldInfo[];
}

/** A field of a store. */
export interface FieldInfo {
  name: string;
  /** value = offset + scale · quantized value. */
  mapping: { offset: number; scale: number; maxError: number; bits: 8 | 16; hasMissing: boolean };
  /** The smallest and largest value of the field, not only on a surface. */
  range: [number, number];
  /** The same as quantized values. */
  quantizedRange: [number, number];
  missingVoxels: number;
  /** Where the field lies in the store's file. */
  offset: number;
  bytes: number;
}

/** Counts of equal parts of the range from low to high. */
export interface Bins {
  low: number;
  high: number;
  counts: number[];
}

/** A value of a field whose values are labels. */
export interface Category {
  value: number;
  /** #rrggbb, sRGB. */
  colour: string;
  /** May be empty. */
  name: string;
}

/** Texts for display. Every field may be missing. */
export interface StoreMetadata {
  name?: string;
  title?: string;
  units?: string;
  source?: Record<string, unknown>;
  /** What the coordinates of the world refer to. Missing: unknown. */
  frame_of_reference?: string;
  histogram?: Bins;
  /** A table of the same form. The counts are the cells of level 0 that are active at the middle of each bin. */
  active_cells?: Bins;
  suggested_isovalues?: number[];
  /** Of a field whose values are labels: value, colour (#rrggbb) and name of each. See categoriesOf. */
  categories?: [number, string, string?][];
  /** The assumptions made when the volume was imported, one sentence each. */
  notes?: string[];
  [key: string]: unknown;
}

/** The samples at the centres of a chunk's cells; arrays of three per sample are x, y, z. */
export interface Samples {
  count: number;
  /** World positions. */
  positions: Float32Array;
  /** In the units of the volume. */
  values: Float32Array;
  /** Values per world unit. */
  gradients: Float32Array;
  /** Lowest and highest value of each cell, two per sample. */
  intervals: Float32Array;
}

/** A chunk's samples as the renderer takes them, in arrays that the caller owns. */
export interface DecodedChunk {
  /** PackedSample, four words each, sorted by region. */
  samples: Uint32Array;
  /** Bytes for the renderer: the range of samples, interval and bounding box of each region. */
  clusters: Uint8Array;
  /** The values of a field at the corners of the samples' cells: PackedField, four words each. */
  field?: { info: FieldInfo; values: Uint32Array };
}

/** Points of an isosurface, x, y, z each; normals of unit length, towards smaller values. */
export interface Points {
  count: number;
  positions: Float32Array;
  normals: Float32Array;
}
