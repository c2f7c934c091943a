import { maxSceneBytes } from "../../scene/scene_document.ts";
import type { SceneSource } from "../../scene/scene_source.ts";

/**
 * The scene in a file of this device whose stores are all at addresses, like a scene that the page has saved. Only
 * this file is read from the device, so requests to other hosts remain allowed. Null for other files.
 */
export async function addressedScene(file: File): Promise<SceneSource | null> {
  if (!/\.json$/i.test(file.name) || file.size > maxSceneBytes) return null;
  if (!(await file.text()).includes('"isosplat-scene"')) return null;
  const [{ isAddress }, { parseScene }, { sceneOfFiles }] = await Promise.all([
    import("../../scene/addressed_stores.ts"),
    import("../../scene/parse_scene.ts"),
    import("../../scene/scene_source.ts"),
  ]);
  try {
    const { layers } = parseScene(new Uint8Array(await file.arrayBuffer()));
    if (!layers.every(({ stores }) => stores.every(isAddress))) return null;
  } catch {
    return null; // the file is then opened like any other file, which reports its faults
  }
  // Browsers add a number to the name of a second download.
  return sceneOfFiles([{ path: "scene.json", file }]);
}
