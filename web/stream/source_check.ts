import type { StoreInfo } from "../core/types.ts";
import type { Backoff } from "./backoff.ts";
import { type FaultKind, isOfPart } from "./faults.ts";
import { cutShort } from "./open_store.ts";
import type { Source } from "./source.ts";
import { StreamError } from "./types.ts";

/**
 * Finds the cause of missing or wrong bytes: reads the identity of the store that is at the source's
 * address now. The store may have been replaced, removed or truncated. At most one check runs at a
 * time.
 */
export class SourceCheck {
  readonly #source: Source;
  readonly #info: StoreInfo;
  readonly #backoff: Backoff;
  readonly #signal: AbortSignal;
  readonly #onReplaced: (error: StreamError) => void;
  #isRunning = false;
  #isReplaced = false;

  /** `onReplaced` is called once, when another store is found at the address. */
  constructor(
    source: Source,
    info: StoreInfo,
    backoff: Backoff,
    signal: AbortSignal,
    onReplaced: (error: StreamError) => void,
  ) {
    this.#source = source;
    this.#info = info;
    this.#backoff = backoff;
    this.#signal = signal;
    this.#onReplaced = onReplaced;
  }

  /** Another store is at the address. Nothing more can be fetched from this one. */
  get isReplaced(): boolean {
    return this.#isReplaced;
  }

  /** Checks the address because of `error`. */
  async run(error: StreamError): Promise<void> {
    if (this.#isRunning || this.#isReplaced || !isOfStore(error.kind)) return;
    this.#isRunning = true;
    try {
      const contentId = await this.#source.contentId(this.#signal);
      this.#compare(contentId, error);
    } catch (reason) {
      if (this.#signal.aborted) return;
      if (reason instanceof StreamError && !reason.retrying) this.#backoff.explain(reason);
    } finally {
      this.#isRunning = false;
    }
  }

  #compare(contentId: string, error: StreamError): void {
    const { name, fileBytes } = this.#source;
    if (contentId !== this.#info.contentId) {
      this.#isReplaced = true;
      const text = `${name}: expected the store ${this.#info.contentId}, found ${contentId}`;
      this.#onReplaced(new StreamError("replaced", text, error));
    } else if (fileBytes !== undefined && fileBytes < this.#info.fileBytes) {
      this.#backoff.explain(cutShort(name, this.#info.fileBytes, fileBytes));
    } else if (!isOfPart(error.kind) && error.kind !== "cut-short") {
      // The file is unchanged and complete: there is no reason to wait.
      this.#backoff.hasten();
    }
  }
}

/** Whether the content at the address can be the cause of such a fault. */
function isOfStore(kind: FaultKind): boolean {
  return !["cors-refused", "worker-lost", "out-of-memory", "internal"].includes(kind);
}
