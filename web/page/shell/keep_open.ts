/**
 * Keeps a dialog open while it makes a file, which closing it would discard: neither Escape nor its cross closes it
 * then, but the focus moves to its button of the class "cancel". `event`: wa-hide.
 */
export function keepOpen(event: Event, isRunning: boolean): void {
  const { target, currentTarget } = event;
  if (!isRunning || target !== currentTarget) return;
  event.preventDefault();
  (currentTarget as HTMLElement).querySelector<HTMLElement>(".cancel")?.focus();
}

/** While a file is being made, the browser asks before it leaves the page. Returns a function that ends this. */
export function askBeforeLeaving(): () => void {
  const ask = (event: Event) => event.preventDefault();
  window.addEventListener("beforeunload", ask);
  return () => window.removeEventListener("beforeunload", ask);
}
