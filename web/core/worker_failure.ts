import { CoreError } from "./calls.ts";

/** What a worker answers when it cannot do what was asked. */
export interface WorkerFailure {
  /** The name in shared/base/status.h, or "worker_lost". */
  status: string;
  message: string;
}

/**
 * The failure to answer for what was thrown. What is no CoreError comes from WebAssembly that has
 * aborted: it cannot be used again.
 */
export function failureOf(error: unknown): WorkerFailure {
  if (error instanceof CoreError) return { status: error.status, message: error.detail };
  return { status: "worker_lost", message: error instanceof Error ? error.message : String(error) };
}
