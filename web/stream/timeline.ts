/** What streaming and drawing take of the main thread, on the browser's timeline: see README.md. */
export type Work = "isosplat:streaming" | "isosplat:drawing";

let underway = false;

/** Does a piece of work and measures it; a piece inside of another one belongs to that. */
export function measured<T>(name: Work, work: () => T): T {
  if (underway) return work();
  underway = true;
  const start = performance.now();
  try {
    return work();
  } finally {
    underway = false;
    performance.measure?.(name, { start });
    // Observers are told; the timeline forgets nothing by itself.
    performance.clearMeasures?.(name);
  }
}
