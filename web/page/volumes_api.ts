/** A volume of the server's list (server/HTTP.md). What a server does not say is missing. */
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
  /** The file is there, but cannot be read. */
  error?: { status: string; message: string };
}

/** The list could not be had. `retry`: the same request may succeed later. */
export class ApiError extends Error {
  override readonly name = "ApiError";
  readonly retry: boolean;
  constructor(message: string, retry: boolean) {
    super(message);
    this.retry = retry;
  }
}

/** The volumes that this page's server offers. */
export async function fetchVolumes(signal?: AbortSignal): Promise<VolumeEntry[]> {
  let response: Response;
  try {
    response = await fetch("v1/volumes", { signal: signal ?? null });
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new ApiError("The server does not answer.", true);
  }
  if (!response.ok) {
    const retry = response.status >= 500 || response.status === 429;
    throw new ApiError(`The server answers ${response.status} to the list of volumes.`, retry);
  }
  try {
    const answer = (await response.json()) as { volumes: VolumeEntry[] };
    return answer.volumes;
  } catch {
    throw new ApiError(
      "The server's list of volumes cannot be read: is it an Isosplat server?",
      false,
    );
  }
}

/**
 * Tries until it succeeds, or fails for good, or the signal ends it. `failed` is told of each
 * failure that is followed by another try, and when that will be.
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
