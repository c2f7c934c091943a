/** What a visitor's browser asks for, with times, as recorded and as replayed. */

export interface RecordedRequest {
  /** Milliseconds since the visit began. */
  at: number;
  /** Path and query. */
  path: string;
  /** The fields Range and Accept-Encoding, where the client sends them. */
  range?: string;
  encoding?: string;
  /** Of the body, as far as it came. */
  bytes: number;
  /** The client gave the request up after so long (ms). */
  cancelledAfter?: number;
}

export interface RecordedVisit {
  volume: string;
  /** What the visitor did. */
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
