import type { Measurement } from "../measure/measurement.ts";
import { writeMeasurement } from "../measure/measurement_text.ts";
import { largestSession, readSession, SessionError } from "../measure/session_file.ts";
import { readUrl, writeUrl } from "./url_state.ts";

/** Where the measurements of a session wait until its page has loaded: links have less of them. */
const storeKey = "isosplat-session";

/** Opens a session file: goes to the page of its view. Throws a SessionError. */
export async function openSession(file: File): Promise<void> {
  if (file.size > largestSession) {
    throw new SessionError(
      `${file.name}: expected a session file of at most ${largestSession} bytes, found ${file.size}`,
    );
  }
  const { view, measurements } = readSession(await file.text());
  const state = readUrl(view);
  if (state.volume === undefined && state.src === undefined) {
    throw new SessionError(`${file.name}: expected "view" to name a volume, or the address of one`);
  }
  const lines = measurements.map(writeMeasurement);
  try {
    sessionStorage.setItem(storeKey, JSON.stringify(measurements));
  } catch {
    // The link has the positions.
  }
  const { measures: _, ...rest } = state;
  location.assign(
    location.pathname + writeUrl({ ...rest, ...(lines.length && { measures: lines }) }),
  );
}

/** The measurements of the session that was opened, if they are those of the address. */
export function keptMeasurements(lines: readonly string[]): readonly Measurement[] | undefined {
  try {
    const text = sessionStorage.getItem(storeKey);
    sessionStorage.removeItem(storeKey);
    if (text === null) return undefined;
    const session = {
      format: "isosplat-session",
      version: 1,
      view: "?",
      measurements: JSON.parse(text),
    };
    const { measurements } = readSession(JSON.stringify(session));
    const isSame =
      measurements.length === lines.length &&
      measurements.every((each, i) => writeMeasurement(each) === lines[i]);
    return isSame ? measurements : undefined;
  } catch {
    return undefined;
  }
}
