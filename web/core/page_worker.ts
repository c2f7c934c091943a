import { assetInBase } from "./assets.ts";

let inheritsPolicy = false;

/**
 * From now on, workers have the Content-Security-Policy that the page has when they start. Otherwise
 * they have the one that their program was sent with: what the page was given later is not in it.
 */
export function startWorkersWithPagePolicy(): void {
  inheritsPolicy = true;
}

/** The addresses of programs, for messages. */
const programs = new WeakMap<Worker, string>();

/**
 * Starts a worker. `start` calls the constructor of the global `Worker` with a `new URL(…, import.meta.url)`
 * whose path is a literal: bundlers recognise this expression, and put the address of the program that they
 * have built into it. `name`: of the program in the folder of `setAssetBase`.
 *
 * Only the constructor is told that address. So, during the call, the global class is one that handles
 * programs of other origins. Throws what the constructor throws.
 */
export function startWorker(name: string, start: () => Worker): Worker {
  const Native = globalThis.Worker;
  /** Its program may be of another origin than the page, or must have the page's policy: see importer. */
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

/** Why a worker has ended. An event without a message: its program could not be loaded. */
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
 * The address of a Blob that imports a program. Browsers allow only workers of the page's own origin,
 * and let those of a Blob inherit the page's policy.
 */
function importer({ href, hash, pathname }: URL, options: WorkerOptions | undefined): string {
  const program = JSON.stringify(href);
  const text = options?.type === "module" ? `import ${program};` : `importScripts(${program});`;
  const address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  // The fragment is the program's own; else its name, for who looks at a page's workers.
  return address + (hash || `#${pathname.slice(pathname.lastIndexOf("/") + 1)}`);
}
