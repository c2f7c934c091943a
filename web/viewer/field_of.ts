import type { FieldInfo, StoreInfo } from "../core/types.ts";

/** The field of a store with this name. */
export function fieldOf({ fields }: StoreInfo, name: string): FieldInfo | null {
  return fields.find((field) => field.name === name) ?? null;
}
