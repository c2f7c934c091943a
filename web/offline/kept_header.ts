/**
 * The time at which a kept response was received, in the format of Date. Only kept responses have this
 * header.
 */
export const keptHeader = "X-Isosplat-Kept";
