import { defaultKeptBytes, KeptBytes } from "../stream/kept_bytes.ts";
import type { Source } from "../stream/source.ts";
import { StreamError } from "../stream/types.ts";
import type { LayerEntry, LayerList } from "./layer_list.ts";
import { LayerSteps, type StepSources } from "./layer_steps.ts";
import type { LayerVolumes } from "./layer_volumes.ts";
import type { OpenVolume } from "./open_volume.ts";
import { abortOf, type RendererLife } from "./renderer_life.ts";
import { samplesOfOthers } from "./sample_budget.ts";
import { StepLoader, type SteppedEntry } from "./step_loader.ts";
import { type SceneTime, Time } from "./time.ts";

/** The functions that a series needs from the list of layers. */
export interface SeriesHost {
  readonly list: LayerList;
  readonly life: RendererLife;
  readonly volumes: LayerVolumes;
  /** Called when another step, and so other volumes, are shown. */
  stepShown(): void;
  busyChanged(): void;
  failed(entry: LayerEntry, error: StreamError): void;
  /** Whether the present picture is complete. */
  isComplete(): boolean;
  /** The name of the field that colours show. */
  shownField(): string | null;
}

/** Opens and closes the steps of all layers, and chooses the one that is shown. */
export class Series {
  readonly time: Time;
  readonly #host: SeriesHost;
  readonly #loader: StepLoader;
  readonly #kept = new KeptBytes(defaultKeptBytes());

  constructor(time: SceneTime, step: number, host: SeriesHost) {
    this.#host = host;
    this.#loader = new StepLoader(() => this.time, {
      entries: () => this.#entries.filter(({ layer }) => layer.visible),
      open: (entry, each) => this.#open(entry.steps.at(each)),
      close: (entry, each) => this.#close([entry.steps.close(each)]),
      isShownComplete: () => host.isComplete(),
      shownField: () => host.shownField(),
    });
    this.time = new Time(time, step, {
      isShowable: (each) => this.#loader.isShowable(each),
      show: (each) => this.#show(each),
      changed: () => this.#loader.changed(),
      cost: () => this.#loader.cost,
      cellPixels: () => this.#loader.cellPixels,
    });
    this.time.on("play", () => this.#loader.chooseDetail());
    this.time.on("buffering", () => host.busyChanged());
  }

  get #entries(): SteppedEntry[] {
    return this.#host.list.entries.filter((entry): entry is SteppedEntry => entry.steps !== null);
  }

  /** StepLoader.shownCellPixels. */
  get shownCellPixels(): number | undefined {
    return this.#loader.shownCellPixels;
  }

  /** The steps of a layer. `make`: see LayerSteps. */
  stepsOf(sources: StepSources, make: (step: number, source: Source) => OpenVolume): LayerSteps {
    return new LayerSteps(sources, this.#kept, make);
  }

  /** The maximum number of samples for a volume of a layer with steps. */
  samplesOf(entry: LayerEntry, volume: OpenVolume): number {
    if (volume !== entry.volume) return this.#loader.samplesOf(entry);
    return entry.samples - samplesOfOthers(entry);
  }

  /** The view that is drawn. */
  viewed(viewProjection: ArrayLike<number>, viewport: { width: number; height: number }): void {
    this.#loader.viewed(viewProjection, viewport);
  }

  /** The surfaces, the layers, or the resident chunks of a step have changed. */
  changed(): void {
    this.#loader.changed();
  }

  drawn(): void {
    this.time.drawn();
  }

  retry(): void {
    for (const entry of this.#entries) {
      for (const { session } of entry.steps.volumes) session?.retry();
    }
    this.#loader.retry();
  }

  /** A step that is not shown has failed. The fault is reported if this step is to be shown. */
  failed(entry: LayerEntry, volume: OpenVolume, error: StreamError): void {
    if (entry.steps?.find(this.time.wantedStep) === volume) this.#host.failed(entry, error);
  }

  /** Another store is at the address of a step that is not shown. */
  replaced(entry: LayerEntry, volume: OpenVolume): void {
    for (const step of entry.steps?.present ?? []) {
      if (entry.steps?.find(step) !== volume) continue;
      volume.source.forget();
      this.#close([entry.steps.close(step)]);
    }
    this.#loader.changed();
  }

  /** Closes all steps of a layer except the shown one, because the layer is hidden or the renderer was replaced. */
  closeOthers(entry: LayerEntry): void {
    if (entry.steps) this.#close(entry.steps.closeOthers(entry.volume));
  }

  close(): void {
    this.time.close();
    this.#loader.close();
    this.#kept.clear();
  }

  async #open(volume: OpenVolume): Promise<void> {
    try {
      await volume.open();
    } catch (error) {
      const abort = abortOf(error);
      if (abort) this.#host.life.replace(abort);
    }
  }

  #close(closed: readonly (OpenVolume | undefined)[]): void {
    const volumes = closed.filter((volume) => volume !== undefined);
    if (volumes.length === 0) return;
    this.#host.volumes.closed();
    if (this.#host.life.isContextLost) return;
    this.#host.life.guard((renderer) => this.#host.volumes.remove(volumes, renderer));
  }

  /** Shows a step of all layers at once. Returns whether a frame follows. */
  #show(step: number): boolean {
    const { life, volumes } = this.#host;
    let isOther = false;
    this.#loader.shown(step);
    for (const entry of this.#entries) {
      const before = entry.volume;
      const next = entry.steps.at(step);
      if (next === before) continue;
      isOther ||= before.session !== null || next.session !== null;
      before.isShown = false;
      this.#loader.hidden(before);
      before.session?.setSampleBudget(this.#loader.samplesOf(entry));
      entry.volume = next;
      next.isShown = true;
      life.guard((renderer) => {
        renderer.volume(before.number).setSurfaces([]);
        if (next.session) volumes.applySurfaces(entry, renderer);
      });
      next.session?.setSampleBudget(this.samplesOf(entry, next));
      if (!entry.layer.visible) this.closeOthers(entry);
    }
    this.#host.stepShown();
    for (const entry of this.#entries) {
      const { error } = entry.volume;
      if (entry.layer.visible && error instanceof StreamError) this.#host.failed(entry, error);
    }
    return isOther && !life.isContextLost;
  }
}
