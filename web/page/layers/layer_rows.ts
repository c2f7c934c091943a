/** The rows of the list of layers: groups, search, the rows in view, and the position of a dropped layer. */

/** A layer in the list. */
export interface LayerEntry {
  key: number;
  title: string;
  group: string;
  visible: boolean;
  /** The colour of its first surface; undefined until its store has been read. */
  colour: string | undefined;
  opacity: number | undefined;
  isChosen: boolean;
  /** Whether it is the page's own volume, which cannot be removed. */
  isFirst: boolean;
  /** Whether its store is being opened. */
  isOpening: boolean;
  /** The reason why the layer is not shown, or not completely. */
  problem: string | undefined;
}

export interface GroupRow {
  kind: "group";
  group: string;
  keys: readonly number[];
  /** How many of its layers are visible. */
  visible: number;
  isCollapsed: boolean;
}

export interface EntryRow {
  kind: "layer";
  entry: LayerEntry;
}

export type ListRow = GroupRow | EntryRow;

/** The layers that have each of these words in their names or in those of their groups. */
export function found(entries: readonly LayerEntry[], query: string): readonly LayerEntry[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return entries;
  return entries.filter(({ title, group }) => {
    const text = `${group} ${title}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** The rows of a list of layers. A group has a row, and its layers follow it, at the position of the first. */
export function rowsOf(
  entries: readonly LayerEntry[],
  collapsed: ReadonlySet<string>,
): readonly ListRow[] {
  const groups = new Map<string, LayerEntry[]>();
  for (const entry of entries) {
    if (entry.group === "") continue;
    const members = groups.get(entry.group);
    if (members) members.push(entry);
    else groups.set(entry.group, [entry]);
  }
  return entries.flatMap((entry): ListRow[] => {
    const { group } = entry;
    if (group === "") return [{ kind: "layer", entry }];
    const members = groups.get(group) ?? [];
    if (members[0] !== entry) return [];
    const isCollapsed = collapsed.has(group);
    const visible = members.filter((each) => each.visible).length;
    const head: ListRow = {
      kind: "group",
      group,
      keys: members.map(({ key }) => key),
      visible,
      isCollapsed,
    };
    if (isCollapsed) return [head];
    return [head, ...members.map((each): ListRow => ({ kind: "layer", entry: each }))];
  });
}

/**
 * The indices of the rows to draw: the rows between `top` and `top + height`, some rows before and after
 * them, and always `kept`, which may have the focus. Lengths are in the unit of `rowHeight`.
 */
export function rowsInView(
  count: number,
  { top, height, rowHeight }: { top: number; height: number; rowHeight: number },
  kept: readonly number[],
): number[] {
  const more = 4;
  const first = Math.max(0, Math.floor(top / rowHeight) - more);
  const end = Math.min(count, Math.ceil((top + height) / rowHeight) + more);
  const inView = Array.from({ length: Math.max(0, end - first) }, (_, i) => first + i);
  const others = kept.filter((i) => i >= 0 && i < count && (i < first || i >= end));
  return [...new Set([...inView, ...others])].sort((a, b) => a - b);
}

/** The new position of a layer: its group, and the layer before or after which it is listed, or the end of the list. */
export interface Drop {
  group: string;
  after?: number;
  before?: number;
}

/**
 * The new position of a layer that is dropped before the row with index `at`, or at the end. A layer that is dropped
 * between two layers of a group, or directly below the group's row, joins the group. A layer that is dropped below
 * the last layer of a group stays in the group if it was in it, and outside otherwise.
 */
export function dropOf(rows: readonly ListRow[], key: number, at: number): Drop | undefined {
  const isMoved = (row: ListRow) => row.kind === "layer" && row.entry.key === key;
  const moved = rows.find(isMoved) as EntryRow | undefined;
  if (!moved) return undefined;
  const above = rows.slice(0, at).findLast((row) => !isMoved(row));
  const below = rows.slice(at).find((row) => !isMoved(row));
  const group = groupBetween(moved.entry.group, above, below);
  if (group !== "" && above?.kind === "layer" && above.entry.group === group) {
    return { group, after: above.entry.key };
  }
  const before = below?.kind === "group" ? below.keys[0] : below?.entry.key;
  return { group, ...(before !== undefined && { before }) };
}

function groupBetween(own: string, above?: ListRow, below?: ListRow): string {
  if (above?.kind === "group") return above.isCollapsed ? "" : above.group;
  const upper = above?.entry.group ?? "";
  const lower = below?.kind === "layer" ? below.entry.group : "";
  return upper !== "" && (upper === lower || upper === own) ? upper : "";
}
