import { StreamError } from "../stream/types.ts";
import { ViewError } from "../viewer/index.ts";
import type { IconName } from "./icons.ts";
import { ApiError } from "./volumes_api.ts";

/** What went wrong, in words, with a way on. */
export interface Problem {
  icon: IconName;
  title: string;
  text: string;
  /** What was expected and found, for a report; shown small. */
  detail?: string;
  /** Offers "Try again". */
  canRetry: boolean;
  /** Offers the list of volumes. */
  offersVolumes: boolean;
}

export function hasWebGl2(): boolean {
  try {
    return document.createElement("canvas").getContext("webgl2") !== null;
  } catch {
    return false;
  }
}

export const noWebGl2: Problem = {
  icon: "alert",
  title: "This browser offers no WebGL 2",
  text:
    "Isosplat draws with WebGL 2. Switch on hardware acceleration in the browser's settings, update " +
    "the graphics driver, or open this address in a current Firefox, Chrome, Edge or Safari.",
  canRetry: true,
  offersVolumes: false,
};

/** `what`: the volume's name or the store's address. */
export function problemOf(error: unknown, what: string): Problem {
  const detail = error instanceof Error ? error.message : String(error);
  if (error instanceof StreamError) return streamProblem(error, what);
  if (error instanceof ViewError) {
    if (!hasWebGl2()) return noWebGl2;
    return {
      icon: "alert",
      title: "The picture cannot be drawn",
      text: "The graphics driver refused. Reload the page; if that does not help, restart the browser.",
      detail,
      canRetry: true,
      offersVolumes: true,
    };
  }
  if (error instanceof ApiError) {
    return {
      icon: "offline",
      title: "The server cannot be reached",
      text: "It may be starting, or the connection is down.",
      detail,
      canRetry: true,
      offersVolumes: false,
    };
  }
  return {
    icon: "alert",
    title: "Something went wrong",
    text: "This is a fault of the page, not of your data. Reload it, and report what follows if it comes back.",
    detail,
    canRetry: true,
    offersVolumes: true,
  };
}

function streamProblem(error: StreamError, what: string): Problem {
  const base = { detail: error.message, canRetry: true, offersVolumes: true };
  switch (error.kind) {
    case "unreachable":
      return {
        ...base,
        icon: "offline",
        title: "The server cannot be reached",
        text: `“${what}” is not there at the moment. It is tried again by itself.`,
      };
    case "not-found":
      return {
        ...base,
        icon: "missing",
        title: "No such volume",
        text: `There is no volume “${what}”. It may have been renamed or removed.`,
        canRetry: false,
      };
    case "range-unsupported":
      return {
        ...base,
        icon: "alert",
        title: "This host does not serve parts of files",
        text:
          "Isosplat reads stores in pieces, by HTTP Range requests, and this host answers with the " +
          "whole file. Put the store on a host that supports Range (nginx, S3 and most object stores " +
          "do), or serve it with “isosplat serve”.",
      };
    case "corrupt":
      return {
        ...base,
        icon: "alert",
        title: "The store is damaged",
        text: "A part of it arrived twice with a wrong checksum. Fetch the store again, or rebuild it.",
      };
    case "bad-store":
      return {
        ...base,
        icon: "alert",
        title: "This is not a store that this page can read",
        text: "It was made by another program, or by a newer version of Isosplat. Rebuild it with “isosplat build”.",
      };
    case "bad-address":
      return {
        ...base,
        icon: "missing",
        title: "This is not the address of a store",
        text: `“${what}” cannot be fetched. Give the http or https address of a store, such as https://example.org/head.isosplat.`,
        canRetry: false,
      };
    default:
      return {
        ...base,
        icon: "alert",
        title: "Something went wrong",
        text: "This is a fault of the page, not of your data. Reload it.",
      };
  }
}
