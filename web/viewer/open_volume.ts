import type { StoreInfo } from "../core/types.ts";
import { StreamSession } from "../stream/session.ts";
import type { SessionOptions } from "../stream/session_parts.ts";
import type { Source } from "../stream/source.ts";
import type { Progress, StreamError, StreamEvents } from "../stream/types.ts";
import { fieldOf } from "./field_of.ts";
import type { RendererError } from "./renderer_error.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";

/** The functions that an open volume needs from the list of layers. */
export interface OpenVolumeHost {
  /** Starts the workers that a session needs. */
  startWorkers(): void;
  /** Options of the session; its events are the volume's. */
  sessionOptions(): Omit<SessionOptions, "events" | "signal">;
  /** The store is open. */
  opened(renderer: RendererModule, info: StoreInfo): void;
  /** The samples of a chunk were uploaded, or the values of a field. */
  uploaded(id: number, of: "samples" | "field"): void;
  /** The first values of a field will be drawn: its description is known. */
  fieldOpened(): void;
  /** Other values of a field are drawn. */
  valuesChanged(): void;
  /** A chunk was added or removed. */
  chunksChanged(): void;
  /** Other chunks are drawn. */
  visibleChanged(): void;
  /** An occlusion query is needed. */
  testOcclusion(): void;
  progressChanged(): void;
  failed(error: StreamError): void;
  /** Another store is at the source's address. */
  replaced(): void;
}

/** The chunks to draw: see StreamEvents.visible. */
interface VisibleChunks {
  ids: Uint32Array;
  regions: Uint32Array;
}

const nothing: VisibleChunks = { ids: new Uint32Array(), regions: new Uint32Array() };

/**
 * The volume of a layer, or of one of its steps: opens its source, and passes the chunks of its stream to the
 * renderer.
 */
export class OpenVolume {
  /** The number of the volume in the renderer. */
  readonly number: number;
  readonly source: Source;
  readonly #life: RendererLife;
  readonly #host: OpenVolumeHost;
  #session: StreamSession | null = null;
  #opening: AbortController | null = null;
  #info: StoreInfo | null = null;
  #progress: Progress | null = null;
  #error: unknown = null;
  #isShown: boolean;
  /** Whether values of the shown field have arrived. */
  #hasValues = false;
  #visible: VisibleChunks = nothing;

  /** `isShown`: see `isShown`. */
  constructor(
    number: number,
    source: Source,
    life: RendererLife,
    host: OpenVolumeHost,
    isShown = true,
  ) {
    this.number = number;
    this.source = source;
    this.#life = life;
    this.#host = host;
    this.#isShown = isShown;
  }

  /** Whether the volume is in the picture. If not, its resident chunks are not drawn. */
  get isShown(): boolean {
    return this.#isShown;
  }

  set isShown(isShown: boolean) {
    this.#isShown = isShown;
    const { ids, regions } = isShown ? this.#visible : nothing;
    if (!this.#session || this.#life.isContextLost) return;
    this.#life.guard((renderer) => renderer.volume(this.number).setVisible(ids, regions));
  }

  /** Why the store could not be opened; null if it was, or is being opened. */
  get error(): unknown {
    return this.#error;
  }

  get isOpening(): boolean {
    return this.#opening !== null && this.#session === null;
  }

  /** Null until the store is open, and after `rest`. */
  get session(): StreamSession | null {
    return this.#session;
  }

  /** Null until the store is open. `rest` does not change it. */
  get info(): StoreInfo | null {
    return this.#info;
  }

  /** The last report; null before the first, and after `rest`. */
  get progress(): Progress | null {
    return this.#progress;
  }

  /** Opens the store, again if it is open. Rejects with a StreamError, RendererError, or a signal's reason. */
  async open(signal?: AbortSignal): Promise<StoreInfo> {
    this.close();
    this.#error = null;
    const opening = new AbortController();
    this.#opening = opening;
    const abort = () => opening.abort(signal?.reason);
    if (signal?.aborted) abort();
    signal?.addEventListener("abort", abort, { once: true });
    opening.signal.addEventListener("abort", () => signal?.removeEventListener("abort", abort));
    try {
      return await this.#openSession(opening.signal);
    } catch (error) {
      if (this.#opening === opening) {
        this.close();
        this.#error = error;
      }
      throw error;
    }
  }

  async #openSession(signal: AbortSignal): Promise<StoreInfo> {
    // Workers and the store's header load at the same time as the renderer.
    this.source.warm();
    this.#host.startWorkers();
    const { renderer, core } = await this.#life.load();
    signal.throwIfAborted();
    // They depend on the other layers of a scene, which have now been added.
    const options = this.#host.sessionOptions();
    const events = this.#streamEvents();
    const session = await StreamSession.open(this.source, core, { ...options, events, signal });
    if (signal.aborted) {
      session.close();
      signal.throwIfAborted();
    }
    this.#session = session;
    this.#info = session.info;
    this.#life.warmUp();
    this.#host.opened(renderer, session.info);
    return session.info;
  }

  #streamEvents(): StreamEvents {
    const { number } = this;
    return {
      samples: (id, place, samples, clusters) => {
        // The volume is opened again when the context is restored.
        if (this.#life.isContextLost) return true;
        const isTaken = this.#life.guard((renderer) =>
          renderer.volume(number).addChunk(id, place, samples, clusters),
        );
        if (isTaken) {
          this.#host.uploaded(id, "samples");
          this.#host.chunksChanged();
        }
        return isTaken || this.#life.isContextLost;
      },
      fieldValues: (id, values) => {
        if (!this.#hasValues) {
          this.#hasValues = true;
          this.#host.fieldOpened();
        }
        this.#life.guard((renderer) => renderer.volume(number).addField(id, values));
        this.#host.uploaded(id, "field");
        if (this.#isShown) this.#host.valuesChanged();
      },
      readSamples: (id) => {
        let samples: Uint32Array | undefined;
        this.#life.guard((renderer) => {
          samples = renderer.volume(number).readSamples(id);
        });
        return samples;
      },
      drop: (id) => {
        this.#life.guard((renderer) => renderer.volume(number).removeChunk(id));
        this.#host.chunksChanged();
      },
      visible: (ids, regions) => {
        this.#visible = { ids, regions };
        if (!this.#isShown) return;
        this.#life.guard((renderer) => renderer.volume(number).setVisible(ids, regions));
        this.#host.visibleChanged();
      },
      testOcclusion: () => this.#host.testOcclusion(),
      progress: (progress) => {
        this.#progress = progress;
        this.#host.progressChanged();
      },
      error: (error) => {
        // Streaming uses the core of the renderer's instance.
        const abort = abortOf(error);
        if (abort) this.#life.replace(abort);
        else this.#host.failed(error);
      },
      replaced: () => this.#host.replaced(),
    };
  }

  /** Shows the field with this name, if the store has it, or none. */
  showField(name: string | null): void {
    const session = this.#session;
    if (!session || this.#life.isContextLost) return;
    const field = name === null ? null : fieldOf(session.info, name);
    if (field?.name === session.shownField?.info.name) return;
    this.#hasValues = false;
    this.#life.guard((renderer) => renderer.volume(this.number).setField(field?.mapping ?? null));
    session.showField(field?.name ?? null);
  }

  /** Ends the volume's requests, and frees its samples. Its `info` stays. */
  rest(): void {
    this.#opening?.abort(
      new DOMException("the volume was closed, or another was opened", "AbortError"),
    );
    this.#opening = null;
    this.#session?.close();
    this.#session = null;
    this.#progress = null;
    this.#visible = nothing;
  }

  close(): void {
    this.rest();
    this.#info = null;
  }

  /** The uploads of these chunks, or of their field values, have failed: the GPU has no memory for them. */
  rejectUploads(samples: readonly number[], values: readonly number[], error: RendererError): void {
    if (samples.length > 0) this.#session?.rejectUploads(samples, error.message);
    if (values.length > 0) this.#session?.rejectFieldValues(values, error.message);
  }
}
