import type { StoreInfo } from "../../core/types.ts";

/** An isovalue that the page offers. */
export interface IsovalueChoice {
  isovalue: number;
}

/** More would not fit into a row of pictures. */
const mostChoices = 4;

/** The isovalues to choose from: those that the store suggests, best first. */
export function isovalueChoices({ metadata }: StoreInfo): IsovalueChoice[] {
  return (metadata.suggested_isovalues ?? [])
    .slice(0, mostChoices)
    .map((isovalue) => ({ isovalue }));
}
