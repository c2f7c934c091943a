import type { Decoder } from "../stream/decoder.ts";
import { defaultReadAheadBytes } from "../stream/read_ahead.ts";
import { RequestLimit } from "../stream/request_limit.ts";
import type { SessionOptions } from "../stream/session_parts.ts";
import { WorkerPool } from "../stream/worker_pool.ts";
import { type LayerEntry, manyLayers } from "./layer_list.ts";
import { compiledRenderer } from "./renderer_program.ts";
import type { ViewerOptions } from "./viewer_events.ts";

/** The workers and the limit of requests that the sessions of all layers share. */
export class LayerSessions {
  readonly #options: ViewerOptions;
  /** The viewer's own workers, if it has no `decoder` of others. */
  #workers: WorkerPool | null = null;
  readonly #requests = new RequestLimit();

  constructor(options: ViewerOptions) {
    this.#options = options;
  }

  /** The viewer's own decoder, or the one that it shares with others. */
  get decoder(): Decoder {
    if (this.#options.decoder) return this.#options.decoder;
    this.#workers ??= new WorkerPool({ renderer: compiledRenderer() });
    return this.#workers;
  }

  /** The options of a session of a layer, which is one of `layers`. */
  optionsOf(
    { layer, hasSurfaces, steps }: LayerEntry,
    sampleBudget: number,
    layers: number,
  ): Omit<SessionOptions, "events" | "signal"> {
    const { targetCellPixels, backgroundBytes, readAheadBytes } = this.#options;
    const firstIsovalues = hasSurfaces ? layer.surfaces.map(({ isovalue }) => isovalue) : [];
    return {
      decoder: this.decoder,
      requests: this.#requests,
      sampleBudget,
      ...(firstIsovalues.length > 0 ? { firstIsovalues } : {}),
      ...(targetCellPixels ? { targetCellPixels } : {}),
      ...(backgroundBytes === undefined ? {} : { backgroundBytes }),
      readAheadBytes: (readAheadBytes ?? defaultReadAheadBytes) / layers,
      // Instead of other isovalues, other steps are fetched in advance.
      ...(steps || layers > manyLayers
        ? { backgroundBytes: 0, readAheadBytes: 0, coarseBytes: 0 }
        : {}),
      // A step that is fetched in advance must not delay the present one.
      ...(steps ? { pausesOthers: false } : {}),
    };
  }

  /** Ends the workers. */
  close(): void {
    this.#workers?.close();
  }
}
