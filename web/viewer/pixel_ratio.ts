/**
 * Calls `changed` whenever the window has another devicePixelRatio: it was moved to another screen,
 * or zoomed. The answer ends that.
 */
export function onPixelRatio(changed: () => void): () => void {
  let query: MediaQueryList | undefined;
  const again = () => {
    watch();
    changed();
  };
  // A query is for one ratio: once that has gone, another is needed.
  const watch = () => {
    query = matchMedia(`(resolution: ${devicePixelRatio}dppx)`);
    query.addEventListener("change", again, { once: true });
  };
  watch();
  return () => query?.removeEventListener("change", again);
}
