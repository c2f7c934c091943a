export {
  type MissingLayer,
  type OpenSceneOptions,
  openScene,
  type ShownScene,
} from "./open_scene.ts";
export { parseScene } from "./parse_scene.ts";
export * from "./scene_document.ts";
export {
  bundleScene,
  type OpenedScene,
  type SceneFile,
  type SceneSource,
  sceneAt,
  sceneOfFiles,
  servedScene,
} from "./scene_source.ts";
export type { ServedSceneOptions } from "./served_bundle.ts";
export { type WriteSceneOptions, type WrittenScene, writeScene } from "./write_scene.ts";
