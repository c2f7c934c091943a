import type { CoreSelection } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import type { ChunkQueue } from "./chunk_queue.ts";
import type { ChunkUploads } from "./chunk_uploads.ts";
import type { Preparation } from "./fetch_ahead.ts";
import type { Motion } from "./motion.ts";
import type { OcclusionQueries } from "./occlusion_queries.ts";
import type { PageLoader } from "./page_loader.ts";
import type { Source } from "./source.ts";
import type { Progress, StreamError } from "./types.ts";

/** The inputs of progress. */
export interface ProgressInputs {
  source: Source;
  queue: ChunkQueue<DecodedChunk>;
  pages: PageLoader;
  uploads: ChunkUploads;
  motion: Motion;
  occlusion: OcclusionQueries;
  /** The last selection. */
  selection: CoreSelection | undefined;
  /** See SelectionLoop.isHere. */
  isHere: boolean;
  /** Another selection is requested. */
  isSelectionPending: boolean;
  isLoadingCoarse: boolean;
  preparation: Preparation | null;
  /** The reason why the source does not respond at present. */
  sourceFault: StreamError | undefined;
}

export function progressOf(inputs: ProgressInputs): Progress {
  const { source, queue, pages, uploads, selection } = inputs;
  const { residency, fields } = uploads;
  // Chunks that wait for the values of a field have arrived.
  const load = selection?.load.filter(({ handle }) => !fields.isHeld(handle)) ?? [];
  const work = remainingWork(inputs);
  const limitedByBudget = (selection?.limitedByBudget ?? false) || queue.full;
  const sourceFault = work.isDone ? undefined : (inputs.sourceFault ?? fields.trouble);
  const state = stateOf(inputs, work, sourceFault, limitedByBudget);
  const [chunkDamage, pageDamage, fieldDamage] = [queue.damaged, pages.damaged, fields.damaged];
  const damage = pageDamage.error ?? chunkDamage.error ?? fieldDamage.error;
  const fault = sourceFault ?? damage ?? uploads.overflow ?? fields.trouble;
  return {
    state,
    chunksToGo: load.length + fields.missing.chunks,
    bytesToGo: load.reduce((bytes, chunk) => bytes + chunk.bytes, fields.missing.bytes),
    bytesFetched: source.bytesReceived,
    requests: source.requests,
    chunksResident: residency.chunks,
    samplesResident: residency.samples,
    sampleBudget: residency.budget,
    finestLevel: selection?.finestLevel ?? -1,
    coarsestLevel: selection?.coarsestLevel ?? -1,
    limitedByBudget,
    complete: state === "complete",
    preparation: state === "complete" ? inputs.preparation : null,
    damagedParts: chunkDamage.count + pageDamage.count + fieldDamage.count,
    fault: fault ? { kind: fault.kind, message: fault.message } : null,
  };
}

interface RemainingWork {
  /** Whether all missing chunks have failed, and no request is in progress. */
  isSettled: boolean;
  /** Whether nothing is missing. */
  isDone: boolean;
  /** Whether missing chunks do not fit into memory, and no pending change will free memory. */
  isFull: boolean;
}

function remainingWork(inputs: ProgressInputs): RemainingWork {
  const { selection, queue, pages, uploads, occlusion } = inputs;
  const isIdle = !inputs.isSelectionPending && !inputs.isLoadingCoarse && uploads.isEmpty;
  if (!selection || !isIdle) return { isSettled: false, isDone: false, isFull: false };
  const hasFailed = ({ handle }: Chunk): boolean =>
    queue.state(handle) === "failed" || uploads.isRejected(handle);
  const isSettled =
    selection.load.every(hasFailed) &&
    selection.pages.every((page) => pages.isDamaged(page)) &&
    selection.undecided === 0 &&
    uploads.fields.missing.chunks === 0 &&
    occlusion.done;
  const isMissingNothing =
    selection.load.length === 0 &&
    selection.pages.length === 0 &&
    uploads.fields.damaged.count === 0;
  return {
    isSettled,
    isDone: isSettled && isMissingNothing,
    isFull: selection.load.length > 0 && queue.full && queue.idle,
  };
}

function stateOf(
  { selection, uploads, isHere, motion, isLoadingCoarse }: ProgressInputs,
  { isSettled, isDone, isFull }: RemainingWork,
  sourceFault: StreamError | undefined,
  limitedByBudget: boolean,
): Progress["state"] {
  const isMoving = (motion.isovalueMoves && !isHere) || motion.cameraMoves;
  const isDrawn = (selection?.finestLevel ?? -1) >= 0;
  const missing =
    (selection?.load.length ?? 0) + (selection?.pages.length ?? 0) + uploads.fields.damaged.count;
  if (sourceFault) return sourceFault.retrying ? "offline" : "incomplete";
  if ((isDone || isFull) && !isMoving) return limitedByBudget ? "limited" : "complete";
  if (!isDrawn && isLoadingCoarse) return "opening";
  if (isMoving) return "waiting";
  if (isSettled && !isDone && missing > 0) return "incomplete";
  return "refining";
}
