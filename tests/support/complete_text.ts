/**
 * The status line of a view for which nothing is left to fetch, and nothing is missing: "complete",
 * or "complete: no surface in this view". Not "complete except for 3 damaged parts".
 */
export const completeText = /^complete(:|$)/;
