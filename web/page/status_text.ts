import type { Progress } from "../stream/types.ts";
import { formatBytes } from "./format.ts";

/** The levels that are drawn; empty if there are none. */
export function levelText({ finestLevel, coarsestLevel }: Progress): string {
  if (finestLevel < 0) return "";
  if (coarsestLevel === 0) return "full resolution";
  if (finestLevel === coarsestLevel) return `level ${finestLevel}`;
  return `levels ${finestLevel}–${coarsestLevel}`;
}

/** What is left to fetch for this view. */
export function stateText(progress: Progress): string {
  const toGo = progress.bytesToGo > 0 ? `${formatBytes(progress.bytesToGo)} to go` : "";
  switch (progress.state) {
    case "complete":
      return completeText(progress) + preparationText(progress);
    case "limited":
      return "limited by memory";
    case "opening":
      return "opening";
    case "offline":
      return progress.fault?.kind === "server-fault"
        ? "server error, trying again"
        : "offline, trying again";
    case "incomplete":
      return incompleteText(progress);
    case "waiting":
      return "";
    case "refining":
      return toGo || "refining";
  }
}

/** The picture is as complete as possible until the fault is repaired. */
function incompleteText({ damagedParts, fault }: Progress): string {
  const isDamaged = fault?.kind === "damaged-part" || fault?.kind === "damaged-page";
  if (!isDamaged || damagedParts === 0) return "parts are missing";
  return `complete except for ${damagedParts} damaged ${damagedParts === 1 ? "part" : "parts"}`;
}

function completeText({ finestLevel }: Progress): string {
  return finestLevel < 0 ? "complete: no surface in this view" : "complete";
}

/** The view needs nothing more: the bytes are for other isovalues. */
function preparationText({ preparation }: Progress): string {
  if (!preparation) return "";
  const { bytes, bytesPlanned } = preparation;
  return ` · preparing other isovalues, ${formatBytes(bytes)} of ${formatBytes(bytesPlanned)}`;
}
