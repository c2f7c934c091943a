import type { Camera, Clip, Slices } from "../viewer/types.ts";

/** The view that linked elements share. */
export interface LinkedView {
  camera?: Camera;
  isovalues?: readonly number[];
  clip?: Clip;
  slices?: Slices;
  /** The value of the step that is shown. */
  time?: number;
}

/** The parts of the view that a link can name. */
export const linkedParts = ["camera", "isovalues", "clip", "slices", "time"] as const;

/** The group of an element, and what it shares there. */
export interface Link {
  group: string;
  parts: ReadonlySet<keyof LinkedView>;
}

/** Reads `GROUP`, which shares all parts, or `GROUP:PART,PART`. Undefined if a part is not known. */
export function readLink(text: string): Link | undefined {
  const [group = "", named, ...more] = text.split(":").map((part) => part.trim());
  if (more.length > 0 || group === "") return undefined;
  if (named === undefined) return { group, parts: new Set(linkedParts) };
  const parts = named.split(",").map((name) => linkedParts.find((part) => part === name.trim()));
  return parts.every((part) => part !== undefined) ? { group, parts: new Set(parts) } : undefined;
}

/** The parts of a view that a link shares. */
export function sharedBy({ parts }: Link, view: LinkedView): LinkedView {
  const shared = Object.entries(view).filter(([part]) => parts.has(part as keyof LinkedView));
  return Object.fromEntries(shared);
}

export interface LinkedElement {
  /** Receives changes of another element of the group. Must not send them on. */
  receive(view: LinkedView): void;
}

/** Elements with the same name of a group show the same view. */
export class LinkGroups {
  readonly #groups = new Map<string, { members: Set<LinkedElement>; view: LinkedView }>();

  /**
   * Returns the known view of the group. The other elements receive from `own` what the group
   * lacks.
   */
  join(name: string, element: LinkedElement, own: LinkedView = {}): LinkedView {
    const group = this.#groups.get(name) ?? { members: new Set(), view: {} };
    this.#groups.set(name, group);
    group.members.add(element);
    const known = { ...group.view };
    const lacking = Object.entries(own).filter(([part]) => !(part in known));
    if (lacking.length > 0) this.send(name, element, Object.fromEntries(lacking));
    return known;
  }

  leave(name: string, element: LinkedElement): void {
    const group = this.#groups.get(name);
    group?.members.delete(element);
    if (group?.members.size === 0) this.#groups.delete(name);
  }

  /** Changes the view of the group. All members except the sender receive `view`. */
  send(name: string, sender: LinkedElement, view: LinkedView): void {
    const group = this.#groups.get(name);
    if (!group?.members.has(sender)) return;
    Object.assign(group.view, view);
    for (const member of group.members) if (member !== sender) member.receive(view);
  }
}
