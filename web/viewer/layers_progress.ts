import { type Progress, StreamError } from "../stream/types.ts";

import type { LayerEntry } from "./layer_list.ts";

type State = Progress["state"];

/** The states by precedence: the first one that a layer has is the state of the picture. */
const states: readonly State[] = [
  "waiting",
  "refining",
  "opening",
  "offline",
  "incomplete",
  "limited",
  "complete",
];

/** The progress of a layer whose store is being opened. */
export const openingProgress: Progress = nothing("opening", 0);

/** The progress of all visible layers. Null while none of them has reported progress. */
export function progressOfShown(
  entries: readonly Pick<LayerEntry, "layer" | "volume">[],
  sampleBudget: number,
): Progress | null {
  const shown = entries.filter(({ layer }) => layer.visible);
  const isUnknown = ({ volume }: (typeof shown)[0]) => !volume.progress && volume.error === null;
  if (shown.length > 0 && shown.every(isUnknown)) return null;
  const parts = shown.map(({ volume }) => volume.progress ?? progressWithout(volume.error));
  return progressOfLayers(parts, sampleBudget);
}

/** The progress of a layer without a session, because its store is being opened or cannot be opened. */
function progressWithout(error: unknown): Progress {
  if (!(error instanceof StreamError)) return openingProgress;
  const { kind, message } = error;
  return { ...nothing("incomplete", 0), fault: { kind, message } };
}

/** While nothing is known of a layer, or no layer is shown. */
function nothing(state: State, sampleBudget: number): Progress {
  return {
    state,
    chunksToGo: 0,
    bytesToGo: 0,
    bytesFetched: 0,
    requests: 0,
    chunksResident: 0,
    samplesResident: 0,
    sampleBudget,
    finestLevel: -1,
    coarsestLevel: -1,
    limitedByBudget: false,
    complete: state === "complete",
    preparation: null,
    damagedParts: 0,
    fault: null,
  };
}

/** Combines the progress of all visible layers into that of the picture. That of a single layer is unchanged. */
export function progressOfLayers(layers: readonly Progress[], sampleBudget: number): Progress {
  const [first, ...others] = layers;
  if (!first) return nothing("complete", sampleBudget);
  return others.reduce(together, first);
}

function together(a: Progress, b: Progress): Progress {
  const state = stateOfBoth(a.state, b.state);
  const preparations = [a, b].map(({ preparation }) => preparation).filter((each) => !!each);
  return {
    state,
    chunksToGo: a.chunksToGo + b.chunksToGo,
    bytesToGo: a.bytesToGo + b.bytesToGo,
    bytesFetched: a.bytesFetched + b.bytesFetched,
    requests: a.requests + b.requests,
    chunksResident: a.chunksResident + b.chunksResident,
    samplesResident: a.samplesResident + b.samplesResident,
    sampleBudget: a.sampleBudget + b.sampleBudget,
    finestLevel: finest(a.finestLevel, b.finestLevel),
    coarsestLevel: Math.max(a.coarsestLevel, b.coarsestLevel),
    limitedByBudget: a.limitedByBudget || b.limitedByBudget,
    complete: state === "complete",
    preparation:
      state === "complete" && preparations.length > 0
        ? {
            bytes: preparations.reduce((sum, { bytes }) => sum + bytes, 0),
            bytesPlanned: preparations.reduce((sum, { bytesPlanned }) => sum + bytesPlanned, 0),
          }
        : null,
    damagedParts: a.damagedParts + b.damagedParts,
    fault: a.fault ?? b.fault,
  };
}

/** While one layer opens, the picture shows the others: it is being refined. */
function stateOfBoth(a: State, b: State): State {
  const [state = a] = states.filter((each) => each === a || each === b);
  return state === "opening" && a !== b ? "refining" : state;
}

/** Levels are −1 if nothing is drawn. */
function finest(a: number, b: number): number {
  if (a < 0 || b < 0) return Math.max(a, b);
  return Math.min(a, b);
}
