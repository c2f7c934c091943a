import { faults, slowWait } from "../../stream/faults.ts";
import { type Progress, StreamError } from "../../stream/types.ts";
import { startTexts } from "../../texts/start.ts";
import type { RendererError } from "../../viewer/renderer_error.ts";
import type { ListedName } from "../shell/chrome.ts";
import { kindOf, type Problem, problemOf, problemOfFault } from "../shell/problems.ts";
import { fetchScenes, fetchVolumes } from "../shell/volumes_api.ts";
import type { Banner } from "./volume_layout.ts";

/**
 * Faults that prevent the picture of a volume page, or a complete one; and the next attempt to open
 * the volume.
 */
export class VolumeFaults {
  /** Opens the volume again. */
  readonly #reopen: () => void;
  readonly #changed: () => void;
  #problem: Problem | null = null;
  #reopenTimer = 0;
  /** Number of consecutive failures to open it. */
  #failures = 0;
  #others: readonly ListedName[] = [];
  #progress: Progress | null = null;
  /** The renderer's last error, until it draws again. */
  #rendererError: RendererError | null = null;
  #isContextLost = false;

  constructor(reopen: () => void, changed: () => void) {
    this.#reopen = reopen;
    this.#changed = changed;
  }

  /** The reason why the volume could not be opened. */
  get problem(): Problem | null {
    return this.#problem;
  }

  /** Existing volumes or scenes, if that of the address does not exist. */
  get others(): readonly ListedName[] {
    return this.#others;
  }

  get isContextLost(): boolean {
    return this.#isContextLost;
  }

  /** Whether the renderer must be restarted. */
  get hasRendererError(): boolean {
    return this.#rendererError !== null;
  }

  /** Whether nothing will change without further calls. */
  get isSettled(): boolean {
    const { state } = this.#progress ?? {};
    return state === "complete" || state === "incomplete" || state === "offline";
  }

  /** `again`: the message of the last attempt stays until this one succeeds. */
  opening({ again, keepsView }: { again: boolean; keepsView: boolean }): void {
    clearTimeout(this.#reopenTimer);
    if (!again) {
      this.#problem = null;
      this.#failures = 0;
    }
    if (!keepsView) this.#rendererError = null;
  }

  opened(): void {
    this.#failures = 0;
    this.#problem = null;
    this.#rendererError = null;
  }

  /** Returns whether the message, or the state, has changed. */
  progress(progress: Progress | null): boolean {
    const before = this.#progress;
    this.#progress = progress;
    return before?.fault?.kind !== progress?.fault?.kind || before?.state !== progress?.state;
  }

  context(state: "lost" | "restored"): void {
    this.#isContextLost = state === "lost";
  }

  /** The renderer has drawn a frame. */
  drawn(): void {
    if (!this.#rendererError) return;
    this.#rendererError = null;
    this.#changed();
  }

  /** The renderer has failed, while the volume stays open. */
  rendererFailed(error: RendererError): void {
    this.#rendererError = error;
    this.#changed();
  }

  /**
   * The volume cannot be opened. `what`: its name; `isRetryScheduled`: another attempt is already
   * scheduled; `listed`: the kind, if the server lists such names.
   */
  notOpened(
    error: unknown,
    what: string,
    isRetryScheduled: boolean,
    listed: ListedName["kind"] | null,
  ): void {
    this.#problem = problemOf(error, what);
    clearTimeout(this.#reopenTimer);
    const { retry } = faults[kindOf(error)];
    if (!isRetryScheduled && retry !== "never") {
      this.#reopenTimer = window.setTimeout(this.#reopen, slowWait(this.#failures++));
    }
    const isMissing = error instanceof StreamError && error.kind === "not-found";
    if (isMissing && listed === "scene") {
      this.#problem = {
        ...this.#problem,
        title: startTexts.noScene,
        text: startTexts.noSceneText(what),
      };
    }
    this.#changed();
    if (!isMissing || !listed) return;
    namesOf(listed)
      .then((names) => {
        this.#others = names;
        this.#changed();
      })
      .catch(() => {}); // the message is shown without the list
  }

  /** The fault that currently prevents a complete picture, while the volume is open. */
  current(name: string): (Problem & { isWaiting: boolean }) | null {
    if (this.#problem) return null;
    if (this.#isContextLost) return { ...problemOfFault("context-lost", name), isWaiting: true };
    if (this.#rendererError) return { ...problemOf(this.#rendererError, name), isWaiting: false };
    const fault = this.#progress?.fault;
    if (!fault) return null;
    const { kind, message } = fault;
    return { ...problemOfFault(kind, name, message), isWaiting: faults[kind].retry === "soon" };
  }

  /** Stops all further attempts. */
  close(): void {
    clearTimeout(this.#reopenTimer);
  }
}

/** The first volumes or scenes of the server that can be opened. */
async function namesOf(kind: ListedName["kind"]): Promise<ListedName[]> {
  const wanted = { limit: 20 };
  const entries =
    kind === "volume" ? (await fetchVolumes(wanted)).volumes : (await fetchScenes(wanted)).scenes;
  return entries.filter(({ error }) => !error).map(({ name }) => ({ kind, name }));
}

/** A fault shown over a picture. */
export function bannerOf(fault: ReturnType<VolumeFaults["current"]>): Banner | null {
  return fault && { ...fault, text: `${fault.title}. ${fault.text}` };
}
