// Starts encode_thread.ts with tsx, which threads of Node do not inherit.
import { register } from "tsx/esm/api";

register();
await import("./encode_thread.ts");
