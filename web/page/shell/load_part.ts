import { pageTexts } from "../../texts/page.ts";
import { showPageNotice } from "./page_notice.ts";

/** Waits between attempts: the first one and the longest one (ms). */
const firstWait = 500;
const longestWait = 16_000;
/** After this many failures, a message says that a part is missing. */
const silentFailures = 2;
/** After this many failures (some minutes), only the return of the network starts another attempt. */
const timedFailures = 20;

/** What Chromium, Firefox and Safari report, in this order, and Vite of a style sheet. */
const failedImport =
  /Failed to fetch dynamically imported module|error loading dynamically imported module|Importing a module script failed|Unable to preload /i;

/** The number of parts whose loading has failed so often that the message names them. */
let missingParts = 0;
let notice: HTMLElement | null = null;

/**
 * Loads a part of the page's program, by dynamic imports. If the server cannot be reached, tries again, for
 * some minutes and whenever the network returns. Meanwhile a message offers to load the page anew: the browser
 * may remember that an import has failed, and a page that was updated on its server has files of other names.
 */
export async function loadPart<Part>(load: () => Promise<Part>): Promise<Part> {
  for (let failures = 0; ; ++failures) {
    try {
      const part = await load();
      if (failures >= silentFailures) found();
      return part;
    } catch (error) {
      // Not a fault of the network: repeating it would not help.
      if (!(error instanceof Error && failedImport.test(error.message))) throw error;
      if (failures + 1 === silentFailures) ++missingParts;
      if (failures + 1 === silentFailures || failures + 1 === timedFailures) showNotice();
      await soonOrOnline(failures + 1 < timedFailures ? waitAfter(failures) : undefined);
    }
  }
}

/** `wait`: in ms; undefined: waits for the network only. */
function soonOrOnline(wait: number | undefined): Promise<void> {
  return new Promise((resolve) => {
    const timer = wait === undefined ? undefined : setTimeout(done, wait);
    function done(): void {
      clearTimeout(timer);
      removeEventListener("online", done);
      resolve();
    }
    addEventListener("online", done);
  });
}

/**
 * Requests style sheets again that do not load: the code of a part requests its own only once. Call it once,
 * before the first part is loaded.
 */
export function retryStyles(): void {
  const failures = new WeakMap<HTMLLinkElement, number>();
  const failed = async ({ target }: Event) => {
    if (!(target instanceof HTMLLinkElement) || target.rel !== "stylesheet") return;
    const before = failures.get(target) ?? 0;
    await soonOrOnline(waitAfter(before));
    const again = target.cloneNode() as HTMLLinkElement;
    failures.set(again, before + 1);
    target.replaceWith(again);
  };
  document.addEventListener("error", (event) => void failed(event), { capture: true });
}

function waitAfter(failures: number): number {
  return Math.min(longestWait, firstWait * 2 ** failures);
}

/** One of the missing parts has loaded. */
function found(): void {
  if (--missingParts === 0) removeNotice();
}

/** Shows the message about parts that did not load, also if it was dismissed before. */
function showNotice(): void {
  if (notice) return;
  notice = showPageNotice({
    role: "alert",
    text: pageTexts.incomplete,
    buttons: [
      [pageTexts.reload, () => location.reload()],
      [pageTexts.dismiss, removeNotice],
    ],
  });
  notice.className = "page-incomplete";
}

function removeNotice(): void {
  notice?.remove();
  notice = null;
}

/** Shows that part of the page's program did not load, for good. */
export function showIncomplete(): void {
  ++missingParts; // the message stays
  showNotice();
}
