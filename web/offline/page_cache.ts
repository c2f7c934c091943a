/** The files of one build of the page. */
export interface PageBuild {
  /** A hash of all its files. */
  version: string;
  /** Relative to the page; the page itself is "". */
  files: readonly string[];
}

const prefix = "isosplat-page-";
/** The kept file is used if the network has not responded after this time (ms). */
const longestWait = 5000;

/**
 * A cache with all files of a build. Files whose names have a hash come from it. Other files come from
 * the network as long as it responds, so that a new page on the server is shown when it is opened.
 */
export class PageCache {
  readonly #name: string;
  readonly #files: ReadonlySet<string>;
  readonly #base: string;

  /** base: the address of the page, with a slash at the end. */
  constructor({ version, files }: PageBuild, base: string) {
    this.#name = prefix + version;
    this.#files = new Set(files);
    this.#base = base;
  }

  /** Fetches all files. Rejects if one is missing; no file of this build is used then. */
  async install(): Promise<void> {
    const cache = await caches.open(this.#name);
    const requests = [...this.#files].map((path) => {
      const isNew = hasHash(path) ? "default" : "no-cache";
      return new Request(this.#base + path, { cache: isNew });
    });
    await cache.addAll(requests);
  }

  /** Removes all builds except this one and the previous one, which a tab may still show. */
  async removeOld(): Promise<void> {
    const names = (await caches.keys()).filter((name) => name.startsWith(prefix));
    const others = names.filter((name) => name !== this.#name);
    await Promise.all(others.slice(0, -1).map((name) => caches.delete(name)));
  }

  isFile(path: string): boolean {
    return this.#files.has(path) || hasHash(path);
  }

  /** `loading`: the response of a navigation that the browser has begun to load. */
  async answer(
    path: string,
    request: Request,
    loading: Promise<Response | undefined>,
  ): Promise<Response> {
    if (hasHash(path)) return (await caches.match(request)) ?? this.#fetched(request);
    const network = loading.then((answer) => answer ?? fetch(request));
    const kept = await (await caches.open(this.#name)).match(this.#base + path);
    if (!kept) return network;
    const late = new Promise<Response>((resolve) => setTimeout(resolve, longestWait, kept));
    return Promise.race([network.catch(() => kept), late]);
  }

  /**
   * A file that is not fetched with the others, such as another language. It is kept when it is used.
   */
  async #fetched(request: Request): Promise<Response> {
    const answer = await fetch(request);
    if (!answer.ok) return answer;
    try {
      await (await caches.open(this.#name)).put(request, answer.clone());
    } catch {
      // The disk may be full.
    }
    return answer;
  }
}

/** Whether a file never changes: the form of names in vite.config.ts. */
function hasHash(path: string): boolean {
  return /^assets\/[^/]+-[\w-]{8}\.\w+$/.test(path);
}
