import { assetInBase } from "./assets.ts";

let inheritsPolicy = false;

/**
 * From now on, each worker gets the Content-Security-Policy that the page has when the worker starts.
 * Without this call, a worker has the policy of the response that contained its program. That policy
 * lacks what was added to the page's policy later.
 */
export function startWorkersWithPagePolicy(): void {
  inheritsPolicy = true;
}

/** The addresses of the workers' programs, for messages. */
const programs = new WeakMap<Worker, string>();

/**
 * Starts a worker. `start` calls the constructor of the global `Worker` with a `new URL(…, import.meta.url)`
 * whose path is a literal. Bundlers recognise this expression, and replace it by the address of the program
 * that they have built. `name`: the name of the program's file in the folder of `setAssetBase`.
 *
 * Only the constructor receives that address. So, during the call, the global class is replaced by one that
 * handles programs of other origins. Throws what the constructor throws.
 */
export function startWorker(name: string, start: () => Worker): Worker {
  const Native = globalThis.Worker;
  /**
   * A worker whose program may come from another origin than the page, or must have the page's policy:
   * see importer.
   */
  class PageWorker extends Native {
    constructor(program: string | URL, options?: WorkerOptions) {
      const url = new URL(program, globalThis.location?.href);
      super(isImported(url) ? importer(url, options) : program, options);
      programs.set(this, url.href);
    }
  }
  const address = assetInBase(name);
  if (address) return new PageWorker(address, { type: "module" });
  globalThis.Worker = PageWorker;
  try {
    return start();
  } finally {
    globalThis.Worker = Native;
  }
}

/**
 * The reason why a worker has ended. An event without a message means that its program could not be
 * loaded.
 */
export function messageOfLoss(worker: Worker, event: ErrorEvent): string {
  if (event.message) return event.message;
  const program = programs.get(worker) ?? "its program";
  return (
    `a worker could not be started: expected ${program}, and a Content-Security-Policy that allows it ` +
    "(worker-src); load the page again"
  );
}

function isImported({ origin, protocol }: URL): boolean {
  // "null": the program is a Blob of a page that is a file.
  const page = globalThis.location?.origin ?? origin;
  const isForeign = origin !== "null" && origin !== page;
  return isForeign || (inheritsPolicy && protocol !== "blob:");
}

/**
 * The address of a Blob that imports a program. Browsers allow only workers of the page's own origin.
 * Workers started from a Blob inherit the page's policy.
 */
function importer({ href, hash, pathname }: URL, options: WorkerOptions | undefined): string {
  const program = JSON.stringify(href);
  const text = options?.type === "module" ? `import ${program};` : `importScripts(${program});`;
  const address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  // The fragment is that of the program's address, or else its name, which developer tools show.
  return address + (hash || `#${pathname.slice(pathname.lastIndexOf("/") + 1)}`);
}
