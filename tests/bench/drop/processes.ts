import { readdirSync, readFileSync } from "node:fs";
import type { Browser } from "@playwright/test";

/** The parent of each process. */
function parents(): Map<number, number> {
  const found = new Map<number, number>();
  for (const name of readdirSync("/proc")) {
    if (!/^\d+$/.test(name)) continue;
    try {
      const stat = readFileSync(`/proc/${name}/stat`, "latin1");
      // The state and the parent follow the name of the program, which may have spaces and
      // parentheses.
      const parent = stat.slice(stat.lastIndexOf(")") + 2).split(" ")[1];
      found.set(Number(name), Number(parent));
    } catch {} // it has ended
  }
  return found;
}

/** The process and its descendants. */
function tree(root: number): number[] {
  const all = parents();
  const found = [root];
  // This loop appends the children of each process to the list.
  for (const pid of found) {
    for (const [child, parent] of all) if (parent === pid) found.push(child);
  }
  return found;
}

/** Memory of a process and its descendants in MB: proportional set size, shared pages counted once. */
export function treeMegabytes(root: number): number {
  let kilobytes = 0;
  for (const pid of tree(root)) {
    try {
      const rollup = readFileSync(`/proc/${pid}/smaps_rollup`, "utf8");
      kilobytes += Number(/^Pss:\s+(\d+)/m.exec(rollup)?.[1] ?? 0);
    } catch {} // it has ended
  }
  return (kilobytes * 1024) / 1e6;
}

/** Measures the maximum memory of a process tree, less its memory at the start. */
export class MemoryWatch {
  readonly #root: number;
  readonly #before: number;
  readonly #timer: NodeJS.Timeout;
  #most: number;

  constructor(root: number) {
    this.#root = root;
    this.#before = treeMegabytes(root);
    this.#most = this.#before;
    this.#timer = setInterval(() => this.#look(), 100);
  }

  #look(): void {
    this.#most = Math.max(this.#most, treeMegabytes(this.#root));
  }

  /** Ends the measurement. Returns MB. */
  end(): number {
    clearInterval(this.#timer);
    this.#look();
    return this.#most - this.#before;
  }
}

/** The main process of a browser, the parent of all its other processes. */
export async function processOf(browser: Browser): Promise<number> {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  await session.detach();
  const id = processInfo.find(({ type }) => type === "browser")?.id;
  if (!id) throw new Error("the browser did not tell its process");
  return id;
}
