import { keptHeader } from "../../offline/kept_header.ts";
import { startTexts } from "../../texts/start.ts";
import { siteCatalog } from "./site.ts";

/**
 * A volume of the server's list (server/HTTP.md). Fields that the server does not send are
 * undefined.
 */
export interface VolumeEntry {
  name: string;
  title?: string;
  voxels?: number[];
  spacing?: number[];
  /** "u8", "i16", "f32" … */
  type?: string;
  units?: string;
  fileBytes?: number;
  contentId?: string;
  histogram?: { low: number; high: number; counts: number[] };
  range?: [number, number];
  /** The URL of its picture: a path of the server, or a file of a static site. */
  thumbnail?: string;
  /** The file exists, but cannot be read. */
  error?: { status: string; message: string };
}

/** A scene of the list. Fields that the server does not send are undefined. */
export interface SceneEntry {
  name: string;
  title?: string;
  contentId?: string;
  fileBytes?: number;
  layers?: number;
  /** Undefined if the scene does not change with time. */
  steps?: number;
  /** See VolumeEntry.thumbnail. */
  thumbnail?: string;
  error?: { status: string; message: string };
}

/**
 * The list could not be fetched. `retry`: the same request may succeed later. `denied`: a token or
 * link is needed.
 */
export class ApiError extends Error {
  override readonly name = "ApiError";
  readonly retry: boolean;
  readonly denied: boolean;
  constructor(message: string, retry: boolean, denied = false) {
    super(message);
    this.retry = retry;
    this.denied = denied;
  }
}

/** A part of a list of volumes. */
export interface VolumeList {
  volumes: VolumeEntry[];
  /** Number and bytes of the volumes of the whole list. */
  total: number;
  fileBytes: number;
  /**
   * Set if the server does not respond and the list was kept from an earlier visit: the time of
   * that visit.
   */
  keptAt?: Date;
}

/** A part of a list of scenes. */
export interface SceneList {
  scenes: SceneEntry[];
  /** Number of scenes of the whole list. */
  total: number;
}

export interface ListQuery {
  /** Words, each of which a volume or a scene must have in its name or title. */
  query?: string;
  /** Number of entries to skip. */
  offset?: number;
  /** Maximum number of entries to return, at most 1000. Default: 100. */
  limit?: number;
}

/** The volumes of this page's server or static site. */
export async function fetchVolumes(
  wanted: ListQuery = {},
  signal?: AbortSignal,
): Promise<VolumeList> {
  const catalog = siteCatalog();
  if (catalog !== null) return (await fetchSite(catalog, wanted, signal)).volumes;
  return fetchList<VolumeList>(listAddress("volumes", wanted), "volumes", signal);
}

/** The scenes of this page's server or static site. */
export async function fetchScenes(
  wanted: ListQuery = {},
  signal?: AbortSignal,
): Promise<SceneList> {
  const catalog = siteCatalog();
  if (catalog !== null) return (await fetchSite(catalog, wanted, signal)).scenes;
  return fetchList<SceneList>(listAddress("scenes", wanted), "scenes", signal);
}

/** Both lists. */
export async function fetchLists(
  wanted: ListQuery,
  signal: AbortSignal,
): Promise<{ volumes: VolumeList; scenes: SceneList }> {
  const catalog = siteCatalog();
  if (catalog !== null) return fetchSite(catalog, wanted, signal);
  const [volumes, scenes] = await Promise.all([
    fetchVolumes(wanted, signal),
    fetchScenes(wanted, signal),
  ]);
  return { volumes, scenes };
}

/** The lists of a static site, which has one file for both. Sites of older versions have no scenes. */
async function fetchSite(
  catalog: string,
  wanted: ListQuery,
  signal: AbortSignal | undefined,
): Promise<{ volumes: VolumeList; scenes: SceneList }> {
  const site = await fetchList<{
    volumes: VolumeEntry[];
    scenes?: SceneEntry[];
    keptAt?: Date;
  }>(catalog, "volumes", signal);
  const { found, total } = selectEntries(site.scenes ?? [], wanted);
  const kept = site.keptAt && { keptAt: site.keptAt };
  return {
    volumes: { ...selectVolumes(site.volumes, wanted), ...kept },
    scenes: { scenes: found, total },
  };
}

function listAddress(list: string, { query, offset, limit }: ListQuery): string {
  const parameters = [
    query && `query=${encodeURIComponent(query)}`,
    offset && `offset=${offset}`,
    limit && `limit=${limit}`,
  ].filter(Boolean);
  return parameters.length > 0 ? `v1/${list}?${parameters.join("&")}` : `v1/${list}`;
}

/** The part of a whole list that a server would return. */
export function selectVolumes(volumes: readonly VolumeEntry[], wanted: ListQuery): VolumeList {
  const { found, total, fileBytes } = selectEntries(volumes, wanted);
  return { volumes: found, total, fileBytes };
}

function selectEntries<T extends { name: string; title?: string; fileBytes?: number }>(
  entries: readonly T[],
  { query = "", offset = 0, limit = 100 }: ListQuery,
): { found: T[]; total: number; fileBytes: number } {
  const words = query.toLowerCase().split(" ").filter(Boolean);
  const matching = entries.filter(({ name, title }) => {
    const texts = [name, title ?? ""].map((text) => text.toLowerCase());
    return words.every((word) => texts.some((text) => text.includes(word)));
  });
  return {
    found: matching.slice(offset, offset + limit),
    total: matching.length,
    fileBytes: matching.reduce((sum, entry) => sum + (entry.fileBytes ?? 0), 0),
  };
}

/** `member`: the field of the response that contains the list. */
async function fetchList<T extends object>(
  address: string,
  member: "volumes" | "scenes",
  signal: AbortSignal | undefined,
): Promise<T & { keptAt?: Date }> {
  let response: Response;
  try {
    response = await fetch(address, { signal: signal ?? null });
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new ApiError(startTexts.noAnswer, true);
  }
  if (!response.ok) {
    if (response.status === 401 || response.status === 403) {
      throw new ApiError(startTexts.notAdmitted, false, true);
    }
    const retry = response.status >= 500 || response.status === 429;
    throw new ApiError(startTexts.listStatus(response.status), retry);
  }
  try {
    const answer = (await response.json()) as T & Record<typeof member, unknown>;
    const kept = response.headers.get(keptHeader);
    if (Array.isArray(answer[member]))
      return { ...answer, ...(kept && { keptAt: new Date(kept) }) };
  } catch {} // reported below
  throw new ApiError(startTexts.notAList, false);
}

/**
 * Repeats the function until it succeeds, fails permanently, or the signal aborts it. After each
 * failure that will be retried, calls `failed` with the time of the next attempt.
 */
export async function withBackoff<T>(
  attempt: (signal: AbortSignal) => Promise<T>,
  signal: AbortSignal,
  failed: (error: ApiError, nextTryMs: number) => void,
): Promise<T> {
  for (let wait = 1000; ; wait = Math.min(2 * wait, 30_000)) {
    try {
      return await attempt(signal);
    } catch (error) {
      if (!(error instanceof ApiError) || !error.retry || signal.aborted) throw error;
      failed(error, wait);
    }
    await new Promise<void>((resolve, reject) => {
      const timer = setTimeout(resolve, wait);
      signal.addEventListener("abort", () => {
        clearTimeout(timer);
        reject(signal.reason);
      });
    });
  }
}
