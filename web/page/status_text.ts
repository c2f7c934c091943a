import type { Progress } from "../stream/types.ts";
import { formatBytes } from "./format.ts";

/** Which levels are drawn; empty where nothing is. */
export function levelText({ finestLevel, coarsestLevel }: Progress): string {
  if (finestLevel < 0) return "";
  if (coarsestLevel === 0) return "full resolution";
  if (finestLevel === coarsestLevel) return `level ${finestLevel}`;
  return `levels ${finestLevel}–${coarsestLevel}`;
}

/** What is left to do for this view. */
export function stateText(progress: Progress): string {
  const toGo = progress.bytesToGo > 0 ? `${formatBytes(progress.bytesToGo)} to go` : "";
  switch (progress.state) {
    case "complete":
      if (progress.finestLevel < 0) return "complete: no surface in this view";
      return progress.limitedByBudget ? "complete within the memory budget" : "complete";
    case "opening":
      return "opening";
    case "offline":
      return "offline, trying again";
    case "incomplete":
      return "parts are missing";
    case "waiting":
      return "";
    case "refining":
      return toGo || "refining";
  }
}
