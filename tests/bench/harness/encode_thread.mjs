// Starts encode_thread.ts: threads of Node do not inherit tsx.
import { register } from "tsx/esm/api";

register();
await import("./encode_thread.ts");
