/**
 * Registers the service worker of this page. Does nothing if the page cannot have one: the origin is
 * not secure, browsing is private, or the data saver is on.
 */

/** The interval at which a page that stays open checks for a new version (ms). */
const updateInterval = 60 * 60 * 1000;

/**
 * `updated`: called when a new version of the page was fetched completely. The new version is used when
 * its argument is called, which reloads the page, or when all tabs with this page have been closed.
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
 * Requests the data of volumes that this page has fetched, and the page's files (one may be its
 * language), once more through the new service worker, which keeps them. The browser has most of them
 * in its cache.
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
