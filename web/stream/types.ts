/** What the viewer and the page see of streaming. Values and isovalues are in the volume's units. */

import type { Triple } from "../core/index.ts";
import { type FaultKind, faults } from "./faults.ts";

export type { StoreInfo, StoreMetadata, Triple } from "../core/index.ts";

/** Where a chunk's cells are: its level, and its block's index in blocks of 64³ cells of it. */
export interface ChunkPlace {
  level: number;
  block: Triple;
}

/** What is looked at. Give it to `StreamSession.update` whenever it changes. */
export interface CameraView {
  /** World to clip space (projection · view), 16 numbers, column-major as WebGL takes them. */
  viewProjection: ArrayLike<number>;
  /** Drawing size in device pixels. */
  viewport: { width: number; height: number };
  /** The isovalues shown, in values. */
  isovalues: readonly number[];
  /** True while the camera moves: coarser data is asked for then. A moving isovalue is noticed. */
  moving: boolean;
}

/** What there is to do, and what has been done. All counts are exact for what is known so far. */
export interface Progress {
  /**
   * opening: the first surface is on its way. refining: finer data is on its way. waiting: the
   * isovalue or the camera moves, finer data is asked for when it rests. offline: the source does
   * not answer, and is tried again soon. incomplete: what is still wanted has failed, and is tried
   * again slowly; coarser data is shown in its place. `fault` says why, for both. limited: the same
   * as complete, but the sample budget keeps parts coarser than the view could show. complete: all
   * that can be seen is drawn at the level that the view resolves, whatever was looked at before:
   * cells are no larger than `targetCellPixels`, or of level 0.
   */
  state: "opening" | "refining" | "waiting" | "offline" | "incomplete" | "limited" | "complete";
  /** Chunks wanted for this view that are not there yet, and their bytes. */
  chunksToGo: number;
  bytesToGo: number;
  /** Since the session was opened: payload received, requests made. */
  bytesFetched: number;
  requests: number;
  /** Chunks held, and their samples. */
  chunksResident: number;
  samplesResident: number;
  /** Most samples that may be resident. */
  sampleBudget: number;
  /**
   * Finest and coarsest level drawn now, of what is not known to be hidden; −1 where nothing is
   * drawn.
   */
  finestLevel: number;
  coarsestLevel: number;
  /** The budget keeps this view coarser than the screen could show. */
  limitedByBudget: boolean;
  /** `state` is complete: nothing is wanted, loading, failed, or kept coarse by the budget. */
  complete: boolean;
  /** Chunks and directory pages wanted for this view that are damaged. */
  damagedParts: number;
  /** What stands in the way now; null as soon as it does not any more. */
  fault: { kind: FaultKind; message: string } | null;
}

/** Something went wrong. `message` says what was expected, what was found, and the remedy. */
export class StreamError extends Error {
  readonly kind: FaultKind;
  constructor(kind: FaultKind, message: string, cause?: unknown) {
    super(message, cause === undefined ? undefined : { cause });
    this.name = "StreamError";
    this.kind = kind;
  }

  /** The session goes on and tries again by itself, soon. */
  get retrying(): boolean {
    return faults[this.kind].retry === "soon";
  }
}

/**
 * What a session tells its viewer. All calls come from `update` or from a task of their own, never
 * from inside another event.
 */
export interface StreamEvents {
  /**
   * Upload a chunk to the GPU under this id (below 2^32). `samples`: PackedSample, 4 words each,
   * sorted by region. `clusters`: see DecodedChunk. The viewer owns both arrays. Called a few times
   * per frame at most. Returns false if there is no room: the chunk does not become resident, and
   * the sample budget is lowered.
   */
  samples(id: number, place: ChunkPlace, samples: Uint32Array, clusters: Uint8Array): boolean;
  /** The chunk with this id is no longer needed: free it. Never one that is visible. */
  drop(id: number): void;
  /**
   * Draw exactly these chunks from now on. `regions` has 16 words per id, two for each of eight
   * slices in z: bit (x >> 3) + 8·(y >> 3) of the 64 of slice z >> 3 says whether the block's cells
   * (x, y, z) of that region are to be drawn; the others are drawn by finer chunks. Arrays are the
   * viewer's.
   */
  visible(ids: Uint32Array, regions: Uint32Array): void;
  /**
   * An occlusion query is wanted: soon, find out what `occlusionQuery` of the session asks, and call
   * `answerOcclusion`. Without this event, what is hidden behind the picture is fetched as well.
   */
  testOcclusion?(): void;
  progress(progress: Progress): void;
  /** Told once for each run of a fault; `Progress.fault` says how long it lasts. */
  error(error: StreamError): void;
  /**
   * Another store has come to the address. This session shows what it has, and asks for nothing
   * more: close it, and open the source again.
   */
  replaced(error: StreamError): void;
}

export interface StreamOptions {
  events: StreamEvents;
  /** Most samples (16 bytes each, on the GPU) held at a time. Default: by device class. */
  sampleBudget?: number;
  /** Size in pixels up to which a cell is not refined further. Default 1. */
  targetCellPixels?: number;
  /** The same while the camera moves. Default 5: levels in between cost much, and are soon in vain. */
  movingCellPixels?: number;
  /** The isovalues of the first view: their surface comes first. Default: the suggested one. */
  firstIsovalues?: readonly number[];
  /** Ends opening and closes the session, as `close` does. */
  signal?: AbortSignal;
}
