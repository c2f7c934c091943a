import { ServerSource } from "../../stream/server_source.ts";
import { SiteSource } from "../../stream/site_source.ts";
import type { Source } from "../../stream/source.ts";

/**
 * The address of the catalog, if this page is a static site from `isosplat publish`; null if the page
 * has a server.
 */
export function siteCatalog(): string | null {
  return document.querySelector<HTMLMetaElement>("meta[name=isosplat-catalog]")?.content ?? null;
}

/** Where the bytes of a volume of this page come from. */
export function volumeSource(volume: string): Source {
  const catalog = siteCatalog();
  return catalog === null ? new ServerSource({ volume }) : new SiteSource({ catalog, volume });
}
