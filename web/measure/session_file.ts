import type { Triple } from "../stream/types.ts";
import {
  isText,
  longestText,
  type MeasuredPoint,
  type Measurement,
  measurementKinds,
  mostMeasurements,
  mostPointsInAll,
  pointCounts,
} from "./measurement.ts";

/**
 * A session file: the view and the measurements of a volume, as JSON (web/measure/README.md).
 */
export interface Session {
  /** The query of the page's address, with its question mark: the volume and the whole view. */
  view: string;
  /** Identifies the volume's bytes. */
  contentId?: string;
  measurements: readonly Measurement[];
}

export const sessionFormat = "isosplat-session";
const version = 1;
/** A larger file is refused before it is read. */
export const largestSession = 5_000_000;
const longestView = 20_000;

/** The file is not a session: expected, found, remedy. */
export class SessionError extends Error {
  override readonly name = "SessionError";
}

export function writeSession({ view, contentId, measurements }: Session): string {
  const session = {
    format: sessionFormat,
    version,
    view,
    ...(contentId && { content_id: contentId }),
    measurements,
  };
  return `${JSON.stringify(session)}\n`;
}

/** Throws a SessionError for anything that is not a session. */
export function readSession(text: string): Session {
  if (text.length > largestSession) {
    throw new SessionError(`a session has at most ${largestSession} bytes, found ${text.length}`);
  }
  let json: unknown;
  try {
    json = JSON.parse(text);
  } catch {
    throw new SessionError("expected a session file (JSON), found something else");
  }
  const record = recordOf(json);
  if (record?.format !== sessionFormat) {
    throw new SessionError(`expected "format": "${sessionFormat}": this is not a session file`);
  }
  if (record.version !== version) {
    const found = JSON.stringify(record.version);
    throw new SessionError(
      `expected version ${version} of the session format, found ${found}: open it with a newer page`,
    );
  }
  const { view, content_id: contentId, measurements } = record;
  if (typeof view !== "string" || !view.startsWith("?") || view.length > longestView) {
    throw new SessionError('expected "view": the query of an address, such as "?volume=head"');
  }
  if (contentId !== undefined && !(typeof contentId === "string" && contentId.length <= 100)) {
    throw new SessionError('expected "content_id" to be a text');
  }
  if (!Array.isArray(measurements) || measurements.length > mostMeasurements) {
    throw new SessionError(`expected "measurements": a list of at most ${mostMeasurements}`);
  }
  const points = measurements.reduce((sum: number, each) => {
    const some = recordOf(each)?.points;
    return sum + (Array.isArray(some) ? some.length : 0);
  }, 0);
  if (points > mostPointsInAll) {
    throw new SessionError(
      `expected at most ${mostPointsInAll} points in all measurements, found ${points}`,
    );
  }
  return {
    view,
    ...(contentId && { contentId }),
    measurements: measurements.map((entry, i) => measurementOf(entry, i + 1)),
  };
}

function recordOf(value: unknown): Record<string, unknown> | undefined {
  const isRecord = typeof value === "object" && value !== null && !Array.isArray(value);
  return isRecord ? (value as Record<string, unknown>) : undefined;
}

function measurementOf(value: unknown, number: number): Measurement {
  const record = recordOf(value);
  const kind = measurementKinds.find((known) => known === record?.kind);
  if (!record || !kind) {
    throw new SessionError(
      `measurement ${number}: expected "kind" to be one of ${measurementKinds.join(", ")}`,
    );
  }
  const { points, text } = record;
  const [least, most] = pointCounts[kind];
  if (!Array.isArray(points) || points.length < least || points.length > most) {
    const count = least === most ? least : `${least} to ${most}`;
    throw new SessionError(`measurement ${number}: expected ${count} "points" of a ${kind}`);
  }
  if (text === undefined ? !isText(kind, "") : typeof text !== "string" || !isText(kind, text)) {
    throw new SessionError(
      `measurement ${number}: expected "text" of at most ${longestText} characters, and of notes at least one`,
    );
  }
  return {
    kind,
    points: points.map((point) => pointOf(point, number)),
    ...(typeof text === "string" && text !== "" && { text }),
  };
}

function pointOf(value: unknown, number: number): MeasuredPoint {
  const record = recordOf(value);
  const position = tripleOf(record?.position);
  if (!record || !position) {
    throw new SessionError(`measurement ${number}: expected "position": three finite numbers`);
  }
  const normal = tripleOf(record.normal);
  const { value: found, level } = record;
  return {
    position,
    ...(typeof found === "number" && Number.isFinite(found) && { value: found }),
    ...(normal && { normal }),
    ...(typeof level === "number" && Number.isInteger(level) && level >= 0 && { level }),
  };
}

function tripleOf(value: unknown): Triple | undefined {
  const isTriple =
    Array.isArray(value) &&
    value.length === 3 &&
    value.every((n) => typeof n === "number" && Number.isFinite(n));
  return isTriple ? (value as Triple) : undefined;
}
