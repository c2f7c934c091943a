import { writeMeasurement } from "../../measure/measurement_text.ts";
import {
  largestSession,
  readSession,
  type Session,
  SessionError,
  writeSession,
} from "../../measure/session_file.ts";
import { sessionTexts } from "../../texts/session.ts";
import { keptSessionKey, longestQuery, readUrl, writeUrl } from "./url_state.ts";

/** Opens a session file: goes to the page of its view. Throws a SessionError. */
export async function openSession(file: File): Promise<void> {
  if (file.size > largestSession) {
    throw new SessionError(sessionTexts.fileTooLarge(file.name, largestSession, file.size));
  }
  const session = readSession(await file.text());
  const { measures: _, ...state } = readUrl(session.view);
  if (state.volume === undefined && state.scene === undefined && state.src === undefined) {
    throw new SessionError(sessionTexts.noVolume(file.name));
  }
  let query = writeUrl(state);
  if (query.length > longestQuery) {
    // The page takes the layers from the kept session.
    const { layers: _layers, layerOrder: _order, ...picture } = state;
    query = writeUrl(picture);
  }
  if (!keepSession(new URL(query, location.href).search, session)) {
    query = writeUrl({ ...state, measures: session.measurements.map(writeMeasurement) });
  }
  if (query.length > longestQuery) {
    throw new SessionError(sessionTexts.tooLong(file.name, longestQuery));
  }
  location.assign(location.pathname + query);
}

/**
 * Keeps a session in this tab, for the page whose address has this query, since addresses have no
 * space for many measurements. Returns false if the browser does not allow it.
 */
export function keepSession(search: string, session: Session): boolean {
  try {
    sessionStorage.setItem(keptSessionKey, `${search}\n${writeSession(session)}`);
    return true;
  } catch {
    return false;
  }
}

/** The kept session for this query. */
export function keptSession(search: string): Session | undefined {
  try {
    const text = sessionStorage.getItem(keptSessionKey) ?? "";
    const end = text.indexOf("\n");
    return text.slice(0, end) === search ? readSession(text.slice(end + 1)) : undefined;
  } catch {
    return undefined;
  }
}

export function forgetSession(): void {
  try {
    sessionStorage.removeItem(keptSessionKey);
  } catch {
    // Nothing was kept.
  }
}
