export { StreamSession } from "./session.ts";
export type { Source } from "./source.ts";
export * from "./types.ts";
