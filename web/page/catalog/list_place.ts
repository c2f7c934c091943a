/**
 * The place in the start page's list, to which the visitor returns with the browser's Back. The browser itself
 * cannot scroll there, since the list is loaded anew.
 */
export interface ListPlace {
  query: string;
  /** The number of entries that were shown. */
  volumes: number;
  scenes: number;
  /** In CSS pixels from the top. */
  top: number;
}

/** Keeps the place in this entry of the browser's history. */
export function keepPlace(place: ListPlace): void {
  history.replaceState({ ...history.state, listPlace: place }, "");
}

/** The place that was kept when this page of the history was left; undefined for a new page. */
export function keptPlace(): ListPlace | undefined {
  const place = (history.state as { listPlace?: Partial<ListPlace> } | null)?.listPlace;
  if (typeof place?.query !== "string") return undefined;
  const count = (n: unknown) => (typeof n === "number" && n >= 0 ? n : 0);
  const { query, volumes, scenes, top } = place;
  return { query, volumes: count(volumes), scenes: count(scenes), top: count(top) };
}
