import type { Category, StoreMetadata } from "./types.ts";

/** The largest difference of two categories: kMaxCategorySpan in shared/core/categories/categories.h. */
const widest = 65_533;

/** The categories of a field by its metadata, by value; empty if its values are no labels. */
export function categoriesOf({ categories = [] }: StoreMetadata): Category[] {
  return merged([
    categories.map(([value, colour, name = ""]) => ({
      value,
      colour,
      name: name.replace(/\p{Cc}/gu, "").slice(0, 64),
    })),
  ]);
}

/** The categories of several fields, by value. Of equal values, the first is taken. */
export function merged(lists: readonly (readonly Category[])[]): Category[] {
  const found = new Map<number, Category>();
  for (const each of lists.flat()) {
    if (!found.has(each.value)) found.set(each.value, each);
  }
  const sorted = [...found.values()].sort((a, b) => a.value - b.value);
  const first = sorted[0]?.value ?? 0;
  return sorted.filter(({ value }) => value - first <= widest);
}
