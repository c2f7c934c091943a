import type { SceneSource } from "../scene/scene_source.ts";

/**
 * Makes the source of the scene at a URL: see sceneAt. `base`: the
 * URL of the document. Undefined if it is not an http or https URL. The code that reads scenes is loaded by
 * the function alone.
 */
export function sceneOf(scene: string, base: string): (() => Promise<SceneSource>) | undefined {
  const url = URL.canParse(scene, base) ? new URL(scene, base) : undefined;
  if (!url || !/^https?:$/.test(url.protocol)) return undefined;
  return async () => (await import("../scene/scene_source.ts")).sceneAt(url.href);
}
