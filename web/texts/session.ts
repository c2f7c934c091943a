import { part } from "./part.ts";

/** Why a session file cannot be opened. */
export const sessionTexts = part("session", {
  tooLarge: (most: number, found: number) => `a session has at most ${most} bytes, found ${found}`,
  fileTooLarge: (name: string, most: number, found: number) =>
    `${name}: expected a session file of at most ${most} bytes, found ${found}`,
  noVolume: (name: string) =>
    `${name}: expected "view" to contain the name or the address of a volume`,
  tooLong: (name: string, most: number) =>
    `${name}: expected a view and measurements that fit into an address of ${most} characters, since this browser keeps no data of the page: allow the browser to keep data, and open the file again`,
  noJson: "expected a session file (JSON), found something else",
  noSession: (format: string) => `expected "format": "${format}": this is not a session file`,
  otherVersion: (expected: number, found: string) =>
    `expected version ${expected} of the session format, found ${found}: open it with a newer page`,
  noView: 'expected "view": the query of an address, such as "?volume=head"',
  noContentId: 'expected "content_id" to be a text',
  noList: (most: number) => `expected "measurements": a list of at most ${most}`,
  tooManyPoints: (most: number, found: number) =>
    `expected at most ${most} points in all measurements, found ${found}`,
  noKind: (measurement: number, kinds: string) =>
    `measurement ${measurement}: expected "kind" to be one of ${kinds}`,
  counts: (least: number, most: number) => `${least} to ${most}`,
  noPoints: (measurement: number, count: string, kind: string) =>
    `measurement ${measurement}: expected ${count} "points" of a ${kind}`,
  noText: (measurement: number, most: number) =>
    `measurement ${measurement}: expected "text" of at most ${most} characters, and for notes at least one`,
  noPosition: (measurement: number) =>
    `measurement ${measurement}: expected "position": three finite numbers`,
});
