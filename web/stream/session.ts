import type { Core } from "../core/index.ts";
import type { Source } from "./source.ts";
import type { StoreInfo, StreamOptions, ViewState } from "./types.ts";

/** One open volume: fetches, decodes and keeps what the current view needs. */
export class StreamSession {
  private constructor(
    readonly info: StoreInfo,
    readonly source: Source,
  ) {}

  /** Reads the store's head and starts to fetch the coarse levels. Rejects with a StreamError. */
  static open(source: Source, core: Core, options: StreamOptions): Promise<StreamSession> {
    void [source, core, options];
    return Promise.reject(new Error("not built yet"));
  }

  /** What is looked at now. Cheap when nothing has changed; call it once per frame at most. */
  update(view: ViewState): void {
    void view;
  }

  /** Cancels what is under way, drops every chunk, and frees all memory. No event follows. */
  close(): void {}
}
