import { type FaultKind, faults, type Offer } from "../../stream/faults.ts";
import { StreamError } from "../../stream/types.ts";
import { faultTexts } from "../../texts/faults.ts";
import { messageOf, withoutOptions } from "../../texts/without_options.ts";
import { RendererError } from "../../viewer/renderer_error.ts";
import type { IconName } from "./icons.ts";
import { ApiError } from "./volumes_api.ts";

/** A problem as a message, with a remedy for the visitor. */
export interface Problem {
  icon: IconName;
  title: string;
  text: string;
  /** The expected and the found value, for a report; shown in small type. */
  detail?: string;
  offers: readonly Offer[];
}

/** Describes a fault to the visitor. `what`: the volume's name or the store's address. */
export function problemOfFault(kind: FaultKind, what: string, detail?: string): Problem {
  const { title, text } = faultTexts[kind];
  const { offers } = faults[kind];
  return {
    icon: iconOf(kind),
    title,
    text: text.replaceAll("NAME", what),
    offers,
    ...(detail ? { detail: withoutOptions(detail) } : {}),
  };
}

export function problemOf(error: unknown, what: string): Problem {
  const detail = messageOf(error);
  return problemOfFault(kindOf(error), what, detail);
}

export function kindOf(error: unknown): FaultKind {
  if (error instanceof StreamError || error instanceof RendererError) return error.kind;
  return error instanceof ApiError ? "unreachable" : "internal";
}

function iconOf(kind: FaultKind): IconName {
  if (kind === "not-found" || kind === "bad-address") return "missing";
  return kind === "unreachable" || kind === "server-fault" ? "offline" : "alert";
}
