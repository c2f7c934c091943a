/** The requests of a visitor's browser, with their times, as recorded and as replayed. */

export interface RecordedRequest {
  /** Milliseconds since the visit began. */
  at: number;
  /** Path and query. */
  path: string;
  /** The fields Range and Accept-Encoding, where the client sends them. */
  range?: string;
  encoding?: string;
  /** Bytes of the body that arrived. */
  bytes: number;
  /** The time after which the client cancelled the request (ms). */
  cancelledAfter?: number;
}

export interface RecordedVisit {
  volume: string;
  /** The script that the visitor followed. */
  scenario: string;
  /** In the order of their times. */
  requests: RecordedRequest[];
  /** How long the visitor stayed (ms). */
  duration: number;
}

/** One of the replayed visits. */
export interface PlannedVisit {
  /** Milliseconds since the first moment of the replay. */
  at: number;
  visit: RecordedVisit;
}
