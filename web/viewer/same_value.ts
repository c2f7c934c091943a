/** Whether two values are equal in JSON. The order of names in objects does not matter. */
export function sameValue(a: unknown, b: unknown): boolean {
  if (a === b) return true;
  if (typeof a !== "object" || typeof b !== "object" || !a || !b) return false;
  const [of, inside] = [a as Record<string, unknown>, b as Record<string, unknown>];
  const names = Object.keys(of);
  return (
    Array.isArray(a) === Array.isArray(b) &&
    names.length === Object.keys(inside).length &&
    names.every((name) => name in inside && sameValue(of[name], inside[name]))
  );
}
