import { CoreError } from "./calls.ts";

/** The reply of a worker that could not carry out a request. */
export interface WorkerFailure {
  /** The name in shared/core/base/status.h, or "worker_lost". */
  status: string;
  message: string;
}

/**
 * Makes the reply for a thrown error. An error that is not a CoreError comes from WebAssembly that has
 * aborted, and cannot be used again.
 */
export function failureOf(error: unknown): WorkerFailure {
  if (error instanceof CoreError) return { status: error.status, message: error.message };
  return { status: "worker_lost", message: error instanceof Error ? error.message : String(error) };
}
