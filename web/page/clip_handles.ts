import "./clip_handles.css";

/** The handles with their styles: loaded together, at their first use. */
export { ClipHandles } from "../overlay/clip_handles.ts";
