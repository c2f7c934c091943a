import type { Triple } from "../core/types.ts";
import { StreamError } from "../stream/types.ts";
import { maxTextBytes } from "./scene_document.ts";

export const maxNumber = 1e300;
/** Larger integers in JSON are rounded when they are parsed. */
export const maxInteger = 2 ** 53;
const utf8 = new TextEncoder();

/** The value that was found, short enough for a message. */
function shown(value: unknown): string {
  const most = 40;
  if (value === undefined) return "nothing";
  if (Array.isArray(value)) return `a list of ${value.length}`;
  if (value !== null && typeof value === "object") {
    return `an object of ${Object.keys(value).length}`;
  }
  const text = JSON.stringify(value);
  return text.length > most ? `${text.slice(0, most)}…` : text;
}

/** A limit, for messages. */
function plain(limit: number): string {
  return limit === maxNumber ? "1e300" : String(Number(limit.toFixed(6)));
}

/** Makes the error of a scene that cannot be read. */
export function sceneError(message: string): StreamError {
  return new StreamError("not-a-store", `scene: ${message}`);
}

/** The value of a member; `otherwise` if the member is absent. */
export function optional<T, None>(
  member: Member,
  read: (member: Member) => T,
  otherwise: None,
): T | None {
  return member.exists ? read(member) : otherwise;
}

/**
 * A member of a scene's document, with its path for messages. A value that is not as expected throws a
 * StreamError that names the path, what was expected and what was found.
 */
export class Member {
  readonly #value: unknown;
  readonly #path: string;

  constructor(value: unknown, path = "") {
    this.#value = value;
    this.#path = path;
  }

  /** Whether the member is present. A member that is null counts as absent. */
  get exists(): boolean {
    return this.#value !== undefined && this.#value !== null;
  }

  is(value: string): boolean {
    return this.#value === value;
  }

  /** The value, if it is a whole number from 0 and below `count`; otherwise undefined. */
  index(count: number): number | undefined {
    const value = this.#value;
    const isIndex = Number.isInteger(value) && (value as number) >= 0 && (value as number) < count;
    return isIndex ? (value as number) : undefined;
  }

  at(key: string): Member {
    const isObject = this.#value !== null && typeof this.#value === "object";
    const found =
      isObject && Object.hasOwn(this.#value as object, key)
        ? (this.#value as Record<string, unknown>)[key]
        : undefined;
    return new Member(found, this.#path ? `${this.#path}.${key}` : key);
  }

  refuse(expected: string): never {
    const where = this.#path ? `${this.#path}: ` : "";
    throw sceneError(`${where}expected ${expected}, found ${shown(this.#value)}`);
  }

  requireObject(expected: string): void {
    const value = this.#value;
    if (value === null || typeof value !== "object" || Array.isArray(value)) this.refuse(expected);
  }

  list(least: number, most: number): Member[] {
    const value = this.#value;
    if (!Array.isArray(value) || value.length < least || value.length > most) {
      this.refuse(`a list of ${least}${least === most ? "" : ` to ${most}`}`);
    }
    return value.map((entry, i) => new Member(entry, `${this.#path}[${i}]`));
  }

  /** most: in bytes of UTF-8. */
  text(most = maxTextBytes): string {
    const value = this.#value;
    if (typeof value === "string" && utf8.encode(value).length <= most) return value;
    return this.refuse(`a text of at most ${most} bytes`);
  }

  number(least = -maxNumber, most = maxNumber): number {
    const value = this.#value;
    if (typeof value === "number" && value >= least && value <= most) return value;
    const isAny = least === -maxNumber && most === maxNumber;
    return this.refuse(
      isAny ? "a finite number" : `a number from ${plain(least)} to ${plain(most)}`,
    );
  }

  /** Up to maxInteger. */
  integer(least: number): number {
    const value = this.#value;
    const isInteger = typeof value === "number" && Math.floor(value) === value;
    if (isInteger && value >= least && value <= maxInteger) return value;
    return this.refuse(`an integer from ${least < 0 ? "-2^53" : "0"} to 2^53`);
  }

  flag(): boolean {
    return typeof this.#value === "boolean" ? this.#value : this.refuse("true or false");
  }

  vector(least?: number, most?: number): Triple {
    return this.list(3, 3).map((entry) => entry.number(least, most)) as Triple;
  }

  oneOf<T extends string>(texts: readonly T[]): T {
    const found = texts.find((text) => text === this.#value);
    return found ?? this.refuse(`one of ${texts.join(", ")}`);
  }

  /** #rrggbb or, with alpha, #rrggbbaa. */
  colour(withAlpha: boolean): string {
    const form = withAlpha ? /^#[0-9a-f]{6}([0-9a-f]{2})?$/i : /^#[0-9a-f]{6}$/i;
    if (typeof this.#value === "string" && form.test(this.#value)) return this.#value.toLowerCase();
    return this.refuse(withAlpha ? "a colour as #rrggbb or #rrggbbaa" : "a colour as #rrggbb");
  }
}
