import type { Core, Store } from "../core/core.ts";
import type { Chunk } from "../core/records.ts";
import type { DecodedChunk } from "../core/types.ts";
import { BackgroundLoader, defaultBackgroundBytes, savesData } from "./background_loader.ts";
import type { Backoff } from "./backoff.ts";
import { ChunkQueue } from "./chunk_queue.ts";
import { ChunkUploads } from "./chunk_uploads.ts";
import { CoarseLoader } from "./coarse_loader.ts";
import type { Decoder } from "./decoder.ts";
import { defaultSampleBudget } from "./device.ts";
import { KeptSource } from "./kept_source.ts";
import { Motion } from "./motion.ts";
import { OcclusionQueries } from "./occlusion_queries.ts";
import { PageLoader } from "./page_loader.ts";
import { defaultReadAheadBytes, ReadAhead } from "./read_ahead.ts";
import type { RequestLimit } from "./request_limit.ts";
import { SelectionLoop, type SelectionParts } from "./selection_loop.ts";
import type { Source } from "./source.ts";
import { SourceCheck } from "./source_check.ts";
import type { StreamError, StreamOptions } from "./types.ts";

/**
 * `decoder` is not closed with the session. By default, the session has its own workers. `requests` limits the
 * requests of several sessions together.
 */
export type SessionOptions = StreamOptions & {
  decoder?: Decoder;
  requests?: RequestLimit;
  /** Whether the requests of other sessions are paused while the first surface is decoded. Default: true. */
  pausesOthers?: boolean;
};

/** An open store and its source. `closed`: aborts all reads that are still running. */
export interface StoreAccess {
  source: Source;
  store: Store;
  backoff: Backoff;
  closed: AbortSignal;
}

/** The events that the parts report to their session. */
export interface SessionPartsHost {
  /** The resident chunks, or the chunks that can be fetched, have changed. */
  changed(): void;
  /** Chunks that no view needed when they were fetched are resident. */
  advanced(): void;
  /** A movement has ended. */
  rested(): void;
  progressChanged(): void;
  /** A chunk or a page cannot be fetched or decoded. `isFirst`: whether it is the first one with this fault. */
  partFailed(error: StreamError, isFirst: boolean): void;
  failed(error: StreamError): void;
  /** Sets a mark on the browser's timeline. */
  mark(name: string): void;
}

export interface SessionParts extends SelectionParts {
  readAhead: ReadAhead;
  selectionLoop: SelectionLoop;
}

/** Makes the parts of a session, and connects them. */
export function makeSessionParts(
  core: Core,
  access: StoreAccess,
  decoder: Decoder,
  options: SessionOptions,
  host: SessionPartsHost,
): SessionParts {
  const { source, store, backoff, closed } = access;
  const viewer = options.events;
  const ofFields = { core, store: access, decoder, requests: options.requests };
  const budget = options.sampleBudget ?? defaultSampleBudget();
  const uploads = new ChunkUploads(ofFields, budget, viewer, {
    changed: () => host.changed(),
    uploadedInAdvance: () => host.advanced(),
    fieldFailed: (error, isFirst) => {
      if (error.kind !== "out-of-memory") host.partFailed(error, isFirst);
      else if (isFirst) host.failed(error);
    },
    fieldChanged: () => host.progressChanged(),
    coloured: () => host.mark("isosplat:coloured"),
    overflowed: (error) => host.failed(error),
  });
  const { residency } = uploads;
  const queue = new ChunkQueue(
    source,
    decoder,
    backoff,
    {
      admit: (chunk) => residency.reserve(chunk),
      decoded: (chunk, decoded) => uploads.add(chunk, decoded, "view"),
      released: (chunk) => residency.release(chunk.handle),
      failed: (error, isFirst) => host.partFailed(error, isFirst),
      changed: () => host.progressChanged(),
    },
    options.requests,
  );
  const pages = new PageLoader(source, store, backoff, closed, {
    added: () => host.changed(),
    failed: (error, isFirst) => host.partFailed(error, isFirst),
  });
  const coarseEvents = {
    isResident: (handle: number) => residency.has(handle),
    decoded: (chunk: Chunk, decoded: DecodedChunk) => uploads.add(chunk, decoded, "coarse"),
    decodingFirst: (isDecoding: boolean) => {
      if (options.pausesOthers !== false) queue.pauseAll(isDecoding);
    },
    uploaded: () => uploads.drained("coarse"),
    changed: () => host.changed(),
    failed: (error: StreamError) => host.failed(error),
  };
  const { coarseBytes } = options;
  const coarse = new CoarseLoader(source, store, backoff, decoder, coarseEvents, coarseBytes);
  const ahead = options.backgroundBytes ?? defaultBackgroundBytes(store.info.fileBytes);
  const background = new BackgroundLoader(source, store, decoder, savesData() ? 0 : ahead, {
    isResident: (handle) => residency.has(handle) || uploads.isQueued(handle),
    admit: (chunk) => residency.reserveFree(chunk),
    released: (chunk) => residency.release(chunk.handle),
    decoded: (chunk, decoded) => uploads.add(chunk, decoded, "advance"),
    uploaded: () => uploads.drained("advance"),
    changed: () => host.advanced(),
    ended: () => host.mark("isosplat:prepared"),
  });
  const parts: SelectionParts = {
    store,
    queue,
    pages,
    uploads,
    coarse,
    background,
    motion: new Motion(() => host.rested()),
    occlusion: new OcclusionQueries(),
    sourceCheck: new SourceCheck(source, store.info, backoff, closed, (error) =>
      viewer.replaced(error),
    ),
    backoff,
    viewer,
    isKept: source instanceof KeptSource ? (chunk) => source.has(chunk) : undefined,
    mark: (name) => host.mark(name),
  };
  const { targetCellPixels: target = 1, movingCellPixels: moving = 5 } = options;
  const { readAheadBytes = defaultReadAheadBytes } = options;
  const isReadAhead = store.info.fileBytes <= readAheadBytes && !savesData();
  const readAhead = new ReadAhead(source, store, isReadAhead, {
    changed: () => host.advanced(),
    ended: () => host.mark("isosplat:kept"),
  });
  return { ...parts, readAhead, selectionLoop: new SelectionLoop(parts, { target, moving }) };
}
