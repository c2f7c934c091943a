/**
 * The list of all faults between an address and a picture. README.md states for each fault how it is
 * detected, what remains on the screen, and how it ends.
 */

/**
 * When a failed request is repeated automatically. soon: after ¼, ½, 1 … 10 s (backoff.ts). slowly:
 * every 12 to 16 s (`slowWait`), for faults that somebody has to repair. never: only when the visitor
 * asks for it.
 */
export type Retry = "soon" | "slowly" | "never";

/** The actions that the page offers: retry at once, show the list of volumes, reload the page. */
export type Offer = "again" | "volumes" | "reload";

export interface Fault {
  retry: Retry;
  /** What happened: a title, or the first sentence of a banner. */
  title: string;
  /** What it means, and what to do. NAME stands for the volume's name or the store's address. */
  text: string;
  offers: readonly Offer[];
}

/** The first and the longest wait before a slow retry, in milliseconds. */
export const slowRetry = 12_000;
export const longestSlowRetry = 16_000;

/**
 * The wait before the next slow retry after this many failures, in milliseconds: 12 s, 14 s, then
 * always 16 s. Not longer, so that a page recovers within 20 s after a fault has been repaired.
 */
export function slowWait(failedBefore: number): number {
  return Math.min(longestSlowRetry, slowRetry + 2000 * failedBefore);
}

export const faults = {
  unreachable: {
    retry: "soon",
    title: "The server does not answer",
    text: "“NAME” cannot be reached: the server may be starting, or the connection is down. It is tried again by itself.",
    offers: ["again", "volumes"],
  },
  "server-fault": {
    retry: "soon",
    title: "The server answers with an error",
    text: "It may be starting, overloaded, or out of order. “NAME” is tried again by itself.",
    offers: ["again", "volumes"],
  },
  "cors-refused": {
    retry: "slowly",
    title: "This host does not let other sites read its files",
    text:
      "The host of “NAME” answers, but keeps its answer from this page (CORS); or the file is not there. Its operator must send " +
      "“Access-Control-Allow-Origin: *” with every answer, errors too (nginx: add_header … always; isosplat serve: --cors), and " +
      "should send “Access-Control-Expose-Headers: Content-Range, Content-Length, ETag”.",
    offers: ["again", "volumes"],
  },
  "access-denied": {
    retry: "slowly",
    title: "The server refuses access",
    text: "“NAME” is not public, or is not there. Open the whole address or link that you were given: it may have expired. Or ask the owner of “NAME” for access.",
    offers: ["again", "volumes"],
  },
  "not-found": {
    retry: "slowly",
    title: "No such volume",
    text: "There is no volume “NAME”. It may have been renamed or removed. Should it come back, it is opened by itself.",
    offers: ["volumes"],
  },
  replaced: {
    retry: "slowly",
    title: "The volume was replaced",
    text: "“NAME” is another store now. It is opened by itself.",
    offers: ["again", "volumes"],
  },
  "cut-short": {
    retry: "slowly",
    title: "The store was cut short",
    text: "The file of “NAME” is shorter than its own beginning says. Copy it again as a whole, or rebuild it with “isosplat build”.",
    offers: ["again", "volumes"],
  },
  "no-range": {
    retry: "slowly",
    title: "This host does not serve parts of files",
    text:
      "Isosplat reads stores in pieces, by HTTP Range requests, and this host answers with the " +
      "whole file. Put the store on a host that supports Range (nginx, S3 and most object stores " +
      "do), or serve it with “isosplat serve”.",
    offers: ["again", "volumes"],
  },
  "not-a-store": {
    retry: "slowly",
    title: "This is not a store",
    text: "What is at the address of “NAME” was not made by Isosplat. Check the address, or build a store with “isosplat build”.",
    offers: ["again", "volumes"],
  },
  "newer-version": {
    retry: "slowly",
    title: "This store is newer than this page",
    text: "“NAME” was made by a newer version of Isosplat than this page is of. Open it with that version, or rebuild it with this one.",
    offers: ["again", "volumes"],
  },
  "damaged-header": {
    retry: "slowly",
    title: "The store is damaged",
    text: "The beginning of “NAME” is not what it was when it was written. Copy the store again, or rebuild it with “isosplat build”.",
    offers: ["again", "volumes"],
  },
  "damaged-page": {
    retry: "slowly",
    title: "The store is damaged",
    text: "A part of its directory arrived twice with a wrong checksum; the rest is shown. Copy the store again, or rebuild it with “isosplat build”.",
    offers: ["again"],
  },
  "damaged-part": {
    retry: "slowly",
    title: "The store is damaged",
    text: "Parts of it arrived twice with a wrong checksum; coarser ones are shown in their place. Copy the store again, or rebuild it with “isosplat build”.",
    offers: ["again"],
  },
  "out-of-memory": {
    retry: "never",
    title: "The memory is full",
    text: "The picture is coarser than the screen could show. Close other programs or tabs, and try again.",
    offers: ["again"],
  },
  "worker-lost": {
    retry: "slowly",
    title: "The browser ended what decodes the data",
    text: "It may be short of memory. It is started again by itself; close other tabs if this does not go away.",
    offers: ["again", "reload"],
  },
  "no-webgl2": {
    retry: "never",
    title: "This browser offers no WebGL 2",
    text:
      "Isosplat draws with WebGL 2. Switch on hardware acceleration in the browser's settings, update " +
      "the graphics driver, or open this address in a current Firefox, Chrome, Edge or Safari.",
    offers: [],
  },
  "context-lost": {
    retry: "soon",
    title: "The browser took the graphics card away",
    text: "The picture comes back when the browser gives it back.",
    offers: [],
  },
  "renderer-failed": {
    retry: "never",
    title: "The picture cannot be drawn",
    text: "The graphics driver refused. Try again; if that does not help, restart the browser.",
    offers: ["again", "volumes"],
  },
  "bad-address": {
    retry: "never",
    title: "This is not the address of a store",
    text: "“NAME” cannot be fetched. Give the http or https address of a store, such as https://example.org/head.isosplat.",
    offers: ["volumes"],
  },
  internal: {
    retry: "never",
    title: "Something went wrong",
    text: "This is a fault of the page, not of your data. Load the page anew, and report the details if it comes back.",
    offers: ["reload", "volumes"],
  },
} as const satisfies Record<string, Fault>;

export type FaultKind = keyof typeof faults;

/** Faults of single parts: coarser chunks replace the missing one, and everything else continues. */
export function isOfPart(kind: FaultKind): boolean {
  return kind === "damaged-part" || kind === "damaged-page";
}

/**
 * The faults of the core's statuses (shared/base/status.h) and the server's (server/HTTP.md).
 * `undefined`: the HTTP status code decides.
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

/** The fault of an HTTP status code, for answers without a status of the server. */
export function faultOfCode(code: number): FaultKind {
  if (code === 404 || code === 410) return "not-found";
  if (code === 401 || code === 403) return "access-denied";
  if (code === 416) return "cut-short";
  return "server-fault";
}
