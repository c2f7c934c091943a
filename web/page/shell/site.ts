import { ServerSource, SiteSource, type Source } from "../../stream/index.ts";

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
