/**
 * Registers the service worker of this page. Does nothing where pages cannot have one: not a secure
 * origin, private browsing, a browser that saves data.
 */

/** How often a page that stays open asks for a new version (ms). */
const updateInterval = 60 * 60 * 1000;

/**
 * `updated`: called when a new version of the page was fetched completely; it is used when its argument
 * is called, which loads the page anew, or when all tabs with this page have been closed.
 */
export async function registerOffline(updated: (replace: () => void) => void): Promise<void> {
  const { connection } = navigator as { connection?: { saveData?: boolean } };
  const workers = (navigator as Partial<Navigator>).serviceWorker;
  if (!workers || connection?.saveData) return;
  const manifest = document.createElement("link");
  manifest.rel = "manifest";
  manifest.href = "manifest.webmanifest";
  document.head.append(manifest);
  const isFirst = workers.controller === null;
  const registration = await workers.register("service-worker.js").catch(() => undefined);
  if (!registration) return;
  const announce = (): void => {
    const { waiting } = registration;
    if (!waiting || !workers.controller) return;
    updated(() => {
      workers.addEventListener("controllerchange", () => location.reload(), { once: true });
      waiting.postMessage("replace");
    });
  };
  announce();
  registration.addEventListener("updatefound", () => {
    registration.installing?.addEventListener("statechange", announce);
  });
  const update = (): void => void registration.update().catch(() => {}); // no network
  setInterval(update, updateInterval);
  if (isFirst) workers.addEventListener("controllerchange", repeatRequests, { once: true });
}

/**
 * What this page has fetched about volumes, and its own files, of which one may be its language, pass
 * the new service worker, which keeps them. The browser has most of it in its cache.
 */
async function repeatRequests(): Promise<void> {
  const names = performance.getEntriesByType("resource").map(({ name }) => name);
  const bases = ["v1/", "assets/"].map((path) => new URL(path, document.baseURI).href);
  const addresses = bases.flatMap((base) => names.filter((name) => name.startsWith(base)));
  for (const address of new Set(addresses)) {
    await fetch(address, { cache: "force-cache" })
      .then((answer) => answer.arrayBuffer())
      .catch(() => {}); // the next visit keeps it
  }
}
