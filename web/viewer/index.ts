export * from "./clipping.ts";
export { type CameraActions, handleCameraKey } from "./controls.ts";
export * from "./light.ts";
export { onPixelRatio } from "./pixel_ratio.ts";
export { compiledRenderer, RendererError } from "./renderer_module.ts";
export * from "./types.ts";
export { type OpenOptions, Viewer, type ViewerEvents, type ViewerOptions } from "./viewer.ts";
