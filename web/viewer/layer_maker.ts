import type { StoreInfo } from "../core/types.ts";
import type { SessionOptions } from "../stream/session_parts.ts";
import type { Source } from "../stream/source.ts";
import type { StreamError } from "../stream/types.ts";
import type { FrameScheduler } from "./frame_scheduler.ts";
import { Layer, type LayerOptions, type LayerProperty } from "./layer.ts";
import type { LayerEntry } from "./layer_list.ts";
import type { StepSources } from "./layer_steps.ts";
import { OpenVolume } from "./open_volume.ts";
import type { RendererLife } from "./renderer_life.ts";
import type { RendererModule } from "./renderer_module.ts";
import type { Series } from "./series.ts";

/** The events that layers and their volumes report to the list of layers. */
export interface LayerMakerHost {
  readonly life: RendererLife;
  scheduler(): FrameScheduler | null;
  startWorkers(): void;
  /** The description of a field that is shown is known. */
  fieldOpened(): void;
  sessionOptions(entry: LayerEntry, volume: OpenVolume): Omit<SessionOptions, "events" | "signal">;
  changed(entry: LayerEntry, property: LayerProperty): void;
  remove(entry: LayerEntry): void;
  opened(entry: LayerEntry, volume: OpenVolume, renderer: RendererModule, info: StoreInfo): void;
  /** A chunk of the volume was added or removed. */
  chunksChanged(volume: OpenVolume): void;
  /** Other chunks of the volume are drawn. */
  visibleChanged(volume: OpenVolume): void;
  progressChanged(): void;
  failed(entry: LayerEntry, error: StreamError): void;
  replaced(entry: LayerEntry): void;
}

/** Makes layers and their volumes. */
export class LayerMaker {
  readonly #host: LayerMakerHost;
  #nextId = 0;

  constructor(host: LayerMakerHost) {
    this.#host = host;
  }

  /** A layer that is not open. `series`: needed if there is a source for each step. */
  make(
    source: Source | StepSources,
    options: LayerOptions,
    view: LayerEntry["view"],
    hasSurfaces: boolean,
    series: Series | null,
  ): LayerEntry {
    const id = this.#nextId;
    const layer = new Layer(id, options, {
      source: () => entry.volume.source,
      sources: () => source,
      hasSteps: () => entry.steps !== null,
      info: () => entry.volume.info,
      progress: () => entry.volume.progress,
      session: () => entry.volume.session,
      changed: (property) => this.#host.changed(entry, property),
      remove: () => this.#host.remove(entry),
    });
    const own = { isListed: false, hasSurfaces, view, cameraBefore: null, samples: 0 };
    let entry: LayerEntry;
    if (typeof source === "function") {
      if (!series) throw new RangeError("a source for each step needs Viewer.setTime");
      const { time } = series;
      // The volume of each step has a number.
      this.#nextId += time.steps;
      const steps = series.stepsOf(source, (step, of) =>
        this.#volume(() => entry, series, id + step, of, step === time.step),
      );
      entry = { layer, volume: steps.at(time.step), steps, ...own };
    } else {
      ++this.#nextId;
      const volume = this.#volume(() => entry, series, id, source, true);
      entry = { layer, volume, steps: null, ...own };
    }
    return entry;
  }

  /** `isShown`: its step is the present one. */
  #volume(
    entry: () => LayerEntry,
    series: Series | null,
    number: number,
    source: Source,
    isShown: boolean,
  ): OpenVolume {
    const host = this.#host;
    const isPresent = (): boolean => entry().volume === volume;
    const volume: OpenVolume = new OpenVolume(
      number,
      source,
      host.life,
      {
        startWorkers: () => host.startWorkers(),
        sessionOptions: () => host.sessionOptions(entry(), volume),
        opened: (renderer, info) => {
          host.opened(entry(), volume, renderer, info);
          series?.changed();
        },
        uploaded: (id, of) => host.scheduler()?.onUpload({ volume: number, id, of }),
        fieldOpened: () => host.fieldOpened(),
        valuesChanged: () => host.scheduler()?.onVisibleChange(),
        chunksChanged: () => host.chunksChanged(volume),
        visibleChanged: () => host.visibleChanged(volume),
        testOcclusion: () => isPresent() && host.scheduler()?.request(),
        progressChanged: () => {
          if (isPresent()) host.progressChanged();
          series?.changed();
        },
        failed: (error) => {
          if (isPresent()) host.failed(entry(), error);
          else series?.failed(entry(), volume, error);
        },
        replaced: () => {
          if (isPresent()) host.replaced(entry());
          else series?.replaced(entry(), volume);
        },
      },
      isShown,
    );
    return volume;
  }
}
