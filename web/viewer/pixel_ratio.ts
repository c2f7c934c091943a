/**
 * Calls `changed` whenever devicePixelRatio has changed, because the window moved to another screen or
 * the page was zoomed. The returned function removes the listener.
 */
export function onPixelRatio(changed: () => void): () => void {
  let query: MediaQueryList | undefined;
  const again = () => {
    watch();
    changed();
  };
  // A media query matches one ratio only, so each change needs a new query.
  const watch = () => {
    query = matchMedia(`(resolution: ${devicePixelRatio}dppx)`);
    query.addEventListener("change", again, { once: true });
  };
  watch();
  return () => query?.removeEventListener("change", again);
}
