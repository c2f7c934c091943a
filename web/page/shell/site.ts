import type { SceneSource } from "../../scene/scene_source.ts";
import { ServerSource } from "../../stream/server_source.ts";
import { SiteSource } from "../../stream/site_source.ts";
import type { Source } from "../../stream/source.ts";

/**
 * The URL of the catalog, if this page is a static site from `isosplat publish`; null if the page
 * has a server.
 */
export function siteCatalog(): string | null {
  return document.querySelector<HTMLMetaElement>("meta[name=isosplat-catalog]")?.content ?? null;
}

/** The source of a scene of this page. */
export async function sceneSource(scene: string): Promise<SceneSource> {
  const { publishedScene, servedScene } = await import("../../scene/scene_source.ts");
  const catalog = siteCatalog();
  return catalog === null ? servedScene({ scene }) : publishedScene({ catalog, scene });
}

/** The source of a volume of this page. */
export function volumeSource(volume: string): Source {
  const catalog = siteCatalog();
  return catalog === null ? new ServerSource({ volume }) : new SiteSource({ catalog, volume });
}
