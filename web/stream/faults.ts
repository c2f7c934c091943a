import { faultTexts } from "../texts/faults.ts";

/**
 * The list of all faults that can occur between an address and a picture. README.md states for each
 * fault how it is detected, what remains on the screen, and how it ends.
 */

/**
 * When a failed request is repeated automatically. soon: after ¼, ½, 1 … 10 s (backoff.ts). slowly:
 * every 12 to 16 s (`slowWait`), for faults that somebody has to repair. never: only when the visitor
 * requests it.
 */
export type Retry = "soon" | "slowly" | "never";

/** The actions that the page offers: retry at once, show the list of volumes, reload the page. */
export type Offer = "again" | "volumes" | "reload";

export interface Fault {
  retry: Retry;
  /** The fault: a title, or the first sentence of a banner. */
  title: string;
  /** The consequence and the remedy. NAME is replaced by the volume's name or the store's address. */
  text: string;
  offers: readonly Offer[];
}

/** The first and the longest wait before a slow retry, in milliseconds. */
export const slowRetry = 12_000;
export const longestSlowRetry = 16_000;

/**
 * The wait before the next slow retry after this many failures, in milliseconds: 12 s, 14 s, then
 * always 16 s. It is never longer, so that a page recovers within 20 s after a fault has been
 * repaired.
 */
export function slowWait(failedBefore: number): number {
  return Math.min(longestSlowRetry, slowRetry + 2000 * failedBefore);
}

export const faults = {
  unreachable: { retry: "soon", offers: ["again", "volumes"], ...faultTexts.unreachable },
  "server-fault": { retry: "soon", offers: ["again", "volumes"], ...faultTexts["server-fault"] },
  "cors-refused": { retry: "slowly", offers: ["again", "volumes"], ...faultTexts["cors-refused"] },
  "access-denied": {
    retry: "slowly",
    offers: ["again", "volumes"],
    ...faultTexts["access-denied"],
  },
  "not-found": { retry: "slowly", offers: ["volumes"], ...faultTexts["not-found"] },
  replaced: { retry: "slowly", offers: ["again", "volumes"], ...faultTexts.replaced },
  "cut-short": { retry: "slowly", offers: ["again", "volumes"], ...faultTexts["cut-short"] },
  "no-range": { retry: "slowly", offers: ["again", "volumes"], ...faultTexts["no-range"] },
  "not-a-store": { retry: "slowly", offers: ["again", "volumes"], ...faultTexts["not-a-store"] },
  "newer-version": {
    retry: "slowly",
    offers: ["again", "volumes"],
    ...faultTexts["newer-version"],
  },
  "damaged-header": {
    retry: "slowly",
    offers: ["again", "volumes"],
    ...faultTexts["damaged-header"],
  },
  "damaged-page": { retry: "slowly", offers: ["again"], ...faultTexts["damaged-page"] },
  "damaged-part": { retry: "slowly", offers: ["again"], ...faultTexts["damaged-part"] },
  "out-of-memory": { retry: "never", offers: ["again"], ...faultTexts["out-of-memory"] },
  "worker-lost": { retry: "slowly", offers: ["again", "reload"], ...faultTexts["worker-lost"] },
  "no-webgl2": { retry: "never", offers: [], ...faultTexts["no-webgl2"] },
  "context-lost": { retry: "soon", offers: [], ...faultTexts["context-lost"] },
  "renderer-failed": {
    retry: "never",
    offers: ["again", "volumes"],
    ...faultTexts["renderer-failed"],
  },
  "bad-address": { retry: "never", offers: ["volumes"], ...faultTexts["bad-address"] },
  internal: { retry: "never", offers: ["reload", "volumes"], ...faultTexts.internal },
} as const satisfies Record<string, Fault>;

export type FaultKind = keyof typeof faults;

/** Faults of single parts: coarser chunks replace the missing one, and everything else continues. */
export function isOfPart(kind: FaultKind): boolean {
  return kind === "damaged-part" || kind === "damaged-page";
}

/**
 * The fault of a status of the core (shared/core/base/status.h) or of the server (server/HTTP.md).
 * Undefined if the HTTP status code decides.
 */
export function faultOfStatus(status: string): FaultKind | undefined {
  switch (status) {
    case "not_a_store":
      return "not-a-store";
    case "unsupported_version":
      return "newer-version";
    case "truncated":
      return "cut-short";
    case "malformed_header":
      return "damaged-header";
    case "malformed_page":
      return "damaged-page";
    case "checksum_mismatch":
    case "malformed_chunk":
      return "damaged-part";
    case "not_found":
      return "not-found";
    case "io_error":
      return "server-fault";
    case "out_of_memory":
      return "out-of-memory";
    case "worker_lost":
      return "worker-lost";
    default:
      return undefined;
  }
}

/** The fault of an HTTP status code, for responses without a status of the server. */
export function faultOfCode(code: number): FaultKind {
  if (code === 404 || code === 410) return "not-found";
  if (code === 401 || code === 403) return "access-denied";
  if (code === 416) return "cut-short";
  return "server-fault";
}
