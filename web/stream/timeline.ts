/** Measures the main thread's work on the browser's timeline: see README.md. */
export type Work = "isosplat:streaming" | "isosplat:drawing";

let underway = false;

/** Runs and measures work. Nested work counts as part of the outer work. */
export function measured<T>(name: Work, work: () => T): T {
  if (underway) return work();
  underway = true;
  const start = performance.now();
  try {
    return work();
  } finally {
    underway = false;
    performance.measure?.(name, { start });
    // Observers have received the entry. The browser keeps entries until they are cleared.
    performance.clearMeasures?.(name);
  }
}
