export type { StoreInfo, StoreMetadata, Triple } from "../core/types.ts";
export { BlobSource } from "./blob_source.ts";
export { type Decoder, InlineDecoder } from "./decoder.ts";
export { defaultSampleBudget } from "./device.ts";
export {
  type Fault,
  type FaultKind,
  faults,
  longestSlowRetry,
  type Offer,
  slowRetry,
  slowWait,
} from "./faults.ts";
export { FileSource, type SourceOptions } from "./file_source.ts";
export { ServerSource, type ServerSourceOptions } from "./server_source.ts";
export { StreamSession } from "./session.ts";
export type { StoreAccess } from "./session_parts.ts";
export { SiteSource, type SiteSourceOptions } from "./site_source.ts";
export type { Source } from "./source.ts";
export { measured } from "./timeline.ts";
export * from "./types.ts";
export { WorkerPool } from "./worker_pool.ts";
