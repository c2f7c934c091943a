import type { Triple } from "../core/types.ts";
import { sessionTexts } from "../texts/session.ts";
import {
  isText,
  longestText,
  type MeasuredField,
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
/** The maximum length of the title of a layer. */
/** Of the names of layers and fields, and of units. */
const longestName = 1024;
/** A larger file is refused before it is read. */
export const largestSession = 5_000_000;
/** The maximum length of the view. A thousand layers take about 100 letters each. */
const longestView = 1_000_000;

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
    throw new SessionError(sessionTexts.tooLarge(largestSession, text.length));
  }
  let json: unknown;
  try {
    json = JSON.parse(text);
  } catch {
    throw new SessionError(sessionTexts.noJson);
  }
  const record = recordOf(json);
  if (record?.format !== sessionFormat) {
    throw new SessionError(sessionTexts.noSession(sessionFormat));
  }
  if (record.version !== version) {
    const found = JSON.stringify(record.version);
    throw new SessionError(sessionTexts.otherVersion(version, found));
  }
  const { view, content_id: contentId, measurements } = record;
  if (typeof view !== "string" || !view.startsWith("?") || view.length > longestView) {
    throw new SessionError(sessionTexts.noView);
  }
  if (contentId !== undefined && !(typeof contentId === "string" && contentId.length <= 100)) {
    throw new SessionError(sessionTexts.noContentId);
  }
  if (!Array.isArray(measurements) || measurements.length > mostMeasurements) {
    throw new SessionError(sessionTexts.noList(mostMeasurements));
  }
  const points = measurements.reduce((sum: number, each) => {
    const some = recordOf(each)?.points;
    return sum + (Array.isArray(some) ? some.length : 0);
  }, 0);
  if (points > mostPointsInAll) {
    throw new SessionError(sessionTexts.tooManyPoints(mostPointsInAll, points));
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
    throw new SessionError(sessionTexts.noKind(number, measurementKinds.join(", ")));
  }
  const { points, text } = record;
  const [least, most] = pointCounts[kind];
  if (!Array.isArray(points) || points.length < least || points.length > most) {
    const count = least === most ? String(least) : sessionTexts.counts(least, most);
    throw new SessionError(sessionTexts.noPoints(number, count, kind));
  }
  if (text === undefined ? !isText(kind, "") : typeof text !== "string" || !isText(kind, text)) {
    throw new SessionError(sessionTexts.noText(number, longestText));
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
    throw new SessionError(sessionTexts.noPosition(number));
  }
  const normal = tripleOf(record.normal);
  const { value: found, level, layer } = record;
  const voxel = tripleOf(record.voxel);
  const field = fieldOf(record.field);
  return {
    position,
    ...(typeof found === "number" && Number.isFinite(found) && { value: found }),
    ...(normal && { normal }),
    ...(typeof layer === "string" && layer.length <= longestName && { layer }),
    ...(voxel && { voxel }),
    ...(field && { field }),
    ...(typeof level === "number" && Number.isInteger(level) && level >= 0 && { level }),
  };
}

function fieldOf(value: unknown): MeasuredField | undefined {
  const { name, value: found, units, label } = recordOf(value) ?? {};
  if (typeof name !== "string" || name.length > longestName) return undefined;
  if (typeof found !== "number" || !Number.isFinite(found)) return undefined;
  const hasUnits = typeof units === "string" && units.length <= longestName;
  const hasLabel = typeof label === "string" && label.length <= longestName;
  return { name, value: found, ...(hasUnits && { units }), ...(hasLabel && { label }) };
}

function tripleOf(value: unknown): Triple | undefined {
  const isTriple =
    Array.isArray(value) &&
    value.length === 3 &&
    value.every((n) => typeof n === "number" && Number.isFinite(n));
  return isTriple ? (value as Triple) : undefined;
}
