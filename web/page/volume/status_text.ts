import type { Progress } from "../../stream/types.ts";
import { pageTexts } from "../../texts/page.ts";
import { formatBytes } from "../shell/format.ts";

/** The levels that are drawn; empty if there are none. */
export function levelText({ finestLevel, coarsestLevel }: Progress): string {
  if (finestLevel < 0) return "";
  if (coarsestLevel === 0) return pageTexts.fullResolution;
  if (finestLevel === coarsestLevel) return pageTexts.level(finestLevel);
  return pageTexts.levels(finestLevel, coarsestLevel);
}

/** The data still to fetch for this view. isClipped: a part of the volume is hidden. */
export function stateText(progress: Progress, isClipped = false): string {
  const toGo = progress.bytesToGo > 0 ? pageTexts.toGo(formatBytes(progress.bytesToGo)) : "";
  switch (progress.state) {
    case "complete":
      return completeText(progress, isClipped) + preparationText(progress);
    case "limited":
      return pageTexts.limited;
    case "opening":
      return pageTexts.opening;
    case "offline":
      return progress.fault?.kind === "server-fault" ? pageTexts.serverError : pageTexts.offline;
    case "incomplete":
      return incompleteText(progress);
    case "waiting":
      return "";
    case "refining":
      return toGo || pageTexts.refining;
  }
}

/** The picture stays incomplete until the fault is repaired. */
function incompleteText({ damagedParts, fault }: Progress): string {
  const isDamaged = fault?.kind === "damaged-part" || fault?.kind === "damaged-page";
  if (!isDamaged || damagedParts === 0) return pageTexts.missing;
  return pageTexts.damaged(damagedParts);
}

function completeText({ finestLevel }: Progress, isClipped: boolean): string {
  if (isClipped) return finestLevel < 0 ? pageTexts.noSurfaceLeft : pageTexts.clipped;
  return finestLevel < 0 ? pageTexts.noSurface : pageTexts.complete;
}

/** The view is complete: the bytes are for other isovalues. */
function preparationText({ preparation }: Progress): string {
  if (!preparation) return "";
  const { bytes, bytesPlanned } = preparation;
  return ` · ${pageTexts.preparing(formatBytes(bytes), formatBytes(bytesPlanned))}`;
}
