/**
 * Matches the status line of a view without missing parts: "complete", or "complete: no surface in this
 * view". It does not match "complete except for 3 damaged parts".
 */
export const completeText = /^complete(:|$)/;
