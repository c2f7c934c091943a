import type { Decoder } from "../stream/decoder.ts";
import { WorkerPool } from "../stream/worker_pool.ts";
import { compiledRenderer } from "../viewer/renderer_program.ts";
import { ContextPool } from "./context_pool.ts";
import { LinkGroups } from "./link_groups.ts";
import { styles } from "./styles.ts";

/** Maximum number of WebGL contexts for all elements of a page. */
const mostContexts = 4;

/** The contexts, and the groups, of all elements of a page. */
export const contexts = new ContextPool(mostContexts);
export const groups = new LinkGroups();

let sheet: CSSStyleSheet | null = null;
/**
 * The style sheet that all elements share. A style element would require style-src 'unsafe-inline'.
 */
export function sharedSheet(): CSSStyleSheet {
  if (!sheet) {
    sheet = new CSSStyleSheet();
    sheet.replaceSync(styles);
  }
  return sheet;
}

let workers: WorkerPool | null = null;
/** The workers that all elements share. They live as long as the page. */
export function sharedWorkers(): Decoder {
  workers ??= new WorkerPool({ renderer: compiledRenderer() });
  return workers;
}
