/** The types of streaming for the viewer and the page. Isovalues are in the volume's units. */

import type { Triple } from "../core/types.ts";
import { type FaultKind, faults } from "./faults.ts";

/**
 * The position of a chunk's cells: its level, and the index of its block in blocks of 64³ cells of this
 * level.
 */
export interface ChunkPlace {
  level: number;
  block: Triple;
}

/** Camera, image size and isovalues. Pass it to `StreamSession.update` whenever it changes. */
export interface CameraView {
  /** World to clip space (projection · view), 16 numbers, column-major as WebGL takes them. */
  viewProjection: ArrayLike<number>;
  /** Drawing size in device pixels. */
  viewport: { width: number; height: number };
  /** The isovalues to show. */
  isovalues: readonly number[];
  /**
   * True while the camera moves: coarser data is requested then. Moving isovalues are detected
   * automatically.
   */
  moving: boolean;
  /**
   * For a time step while time is playing, or for one that is shown later: the size in pixels up to
   * which cells are not refined. It replaces `targetCellPixels`. With Infinity, nothing is fetched.
   * There are no occlusion queries for such a step, so occluded chunks are fetched as well.
   */
  stepCellPixels?: number;
}

/** The data still missing, and the data fetched. Counts are based on resident directory pages only. */
export interface Progress {
  /**
   * opening: the first surface is being fetched. refining: finer data is being fetched. waiting: the
   * isovalue or the camera moves; finer data is requested at rest. offline: the source does not
   * respond, and is retried soon. incomplete: needed parts have failed, and are retried slowly;
   * coarser data is shown in their place. For both, `fault` is the cause. limited: like complete,
   * but the sample budget keeps parts coarser than the view could show. complete: everything visible
   * is drawn at the level that the view resolves, independently of earlier views: cells are no
   * larger than `targetCellPixels`, or of level 0.
   */
  state: "opening" | "refining" | "waiting" | "offline" | "incomplete" | "limited" | "complete";
  /** Chunks that this view needs and that are not resident, and their bytes. */
  chunksToGo: number;
  bytesToGo: number;
  /** Since the session was opened: payload received, requests made. */
  bytesFetched: number;
  requests: number;
  /** Resident chunks, and their samples. */
  chunksResident: number;
  samplesResident: number;
  /** Most samples that may be resident. */
  sampleBudget: number;
  /**
   * Finest and coarsest level drawn now, without regions known to be occluded; −1 if nothing is
   * drawn.
   */
  finestLevel: number;
  coarsestLevel: number;
  /** The budget keeps this view coarser than the screen could show. */
  limitedByBudget: boolean;
  /** Whether `state` is complete. */
  complete: boolean;
  /**
   * Other isovalues are being fetched (`StreamOptions.backgroundBytes`, `readAheadBytes`): bytes
   * fetched so far, and planned. Null while none are being fetched; a complete view then makes no requests.
   */
  preparation: { bytes: number; bytesPlanned: number } | null;
  /** Damaged chunks and directory pages that this view needs. */
  damagedParts: number;
  /** The present fault; null as soon as it has ended. */
  fault: { kind: FaultKind; message: string } | null;
}

/** A fault of streaming. `message` states what was expected, what was found, and the remedy. */
export class StreamError extends Error {
  readonly kind: FaultKind;
  constructor(kind: FaultKind, message: string, cause?: unknown) {
    super(message, cause === undefined ? undefined : { cause });
    this.name = "StreamError";
    this.kind = kind;
  }

  /** Whether the session continues and retries automatically, soon. */
  get retrying(): boolean {
    return faults[this.kind].retry === "soon";
  }
}

/**
 * The events of a session. They are called from `update` or from a separate task, never from another
 * event.
 */
export interface StreamEvents {
  /**
   * Upload a chunk to the GPU under this id (below 2^32). `samples`: PackedSample, 4 words each, sorted
   * by region. `clusters`: see DecodedChunk. The viewer owns both arrays. Called a few times per frame
   * at most. Returns false if it does not fit into memory: the chunk does not become resident, and the
   * sample budget is lowered.
   */
  samples(id: number, place: ChunkPlace, samples: Uint32Array, clusters: Uint8Array): boolean;
  /**
   * Upload the values of the field that is shown (StreamSession.showField) for the samples of a chunk: PackedField,
   * four words each, in the order of the samples. The viewer owns the array.
   */
  fieldValues?(id: number, values: Uint32Array): void;
  /** The samples of a chunk, read back from the GPU: they are needed to decode its field chunk. */
  readSamples?(id: number): Uint32Array | undefined;
  /** The chunk with this id is no longer needed: free it. It is never a visible chunk. */
  drop(id: number): void;
  /**
   * Draw exactly these chunks from now on. `regions` has 16 words per id: two words, or 64 bits,
   * for each of eight slices in z. A cell (x, y, z) of the block is drawn if bit (x >> 3) + 8·(y >>
   * 3) of slice z >> 3 is set. Finer chunks draw the other cells. The viewer owns both arrays.
   */
  visible(ids: Uint32Array, regions: Uint32Array): void;
  /**
   * An occlusion query is needed: run the session's `occlusionQuery` soon, and call
   * `answerOcclusion`. Without this event, occluded chunks are fetched as well.
   */
  testOcclusion?(): void;
  progress(progress: Progress): void;
  /** Called once for each occurrence of a fault. `Progress.fault` is set as long as it lasts. */
  error(error: StreamError): void;
  /**
   * Another store is at the address. This session shows its resident chunks and requests nothing
   * more: close it, and open the source again.
   */
  replaced(error: StreamError): void;
}

export interface StreamOptions {
  events: StreamEvents;
  /**
   * Most resident samples (16 bytes each, on the GPU). Default: from the device's memory
   * (web/stream/device.ts).
   */
  sampleBudget?: number;
  /** Size in pixels up to which a cell is not refined further. Default 1. */
  targetCellPixels?: number;
  /**
   * The same limit while the camera moves. Default 5, because finer levels would be out of date on arrival.
   */
  movingCellPixels?: number;
  /**
   * Most bytes fetched for other isovalues while a view is complete, so that a moving isovalue has fine
   * cells at once. Default: 4 MB or 0.3 of the store, whichever is less. Always 0 if the browser's data
   * saver is on (`navigator.connection.saveData`).
   */
  backgroundBytes?: number;
  /**
   * A store of at most this many bytes is read as a whole while a view is complete, and kept encoded in memory,
   * so that another isovalue makes no request. Default: 16 MB. Nothing is read ahead from this device, nor if
   * the browser's data saver is on.
   */
  readAheadBytes?: number;
  /**
   * Most bytes of the coarse levels that are fetched for every isovalue when a store is opened. With 0, only the
   * levels that the first surface needs are fetched. Default: 160 KB.
   */
  coarseBytes?: number;
  /** The isovalues of the first view. Their surface is loaded first. Default: the suggested one. */
  firstIsovalues?: readonly number[];
  /** Ends opening and closes the session, as `close` does. */
  signal?: AbortSignal;
}
