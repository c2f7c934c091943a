import { CoalescedTask } from "../stream/coalesced_task.ts";
import { slowRetry } from "../stream/faults.ts";
import type { CameraView } from "../stream/types.ts";
import { Bandwidth } from "./bandwidth.ts";
import type { LayerEntry } from "./layer_list.ts";
import type { LayerSteps } from "./layer_steps.ts";
import type { OpenVolume } from "./open_volume.ts";
import { samplesOfOthers } from "./sample_budget.ts";
import { isStreaming } from "./scene.ts";
import { isovaluesOf, needOf, StepCosts, type StepNeed } from "./step_costs.ts";
import type { Time } from "./time.ts";
import type { PlayCost } from "./time_cost.ts";
import { stepsAhead } from "./time_order.ts";
import { type AheadPlan, cellPixelsThatPlay, planAhead, stepsThatFit } from "./time_plan.ts";
import { viewProjectionOf } from "./transform.ts";

/** The limit of bytes that are fetched before they are shown. */
const aheadBytes = 8 * 1024 * 1024;
/** The number of stores that are opened at the same time. */
const openedTogether = 4;
/** Detail is reduced after this number of consecutive steps that were coarser than planned when they were shown. */
const lateInARow = 3;
/** While the camera moves, the view of steps that are fetched in advance is updated at this interval (ms). */
const viewInterval = 100;
/** The cell size for steps whose finer chunks are not needed now. */
const onlyCoarse = Number.POSITIVE_INFINITY;

/** A layer that has a store for each step. */
export type SteppedEntry = LayerEntry & { readonly steps: LayerSteps };

/** The functions that the loader needs from the layers. */
export interface StepLoaderHost {
  /** The visible layers that have steps. */
  entries(): readonly SteppedEntry[];
  /** Opens a step that is not shown. Never rejects: see OpenVolume.error. */
  open(entry: SteppedEntry, step: number): Promise<void>;
  /** Closes a step that is not shown. */
  close(entry: SteppedEntry, step: number): void;
  /** Whether the step that is shown is complete. */
  isShownComplete(): boolean;
  /** The name of the field that colours show. */
  shownField(): string | null;
}

/** The view of a picture: world to clip space, and its size. */
type View = Pick<CameraView, "viewProjection" | "viewport">;

/** The last request to a volume: the view and the cell size in pixels. */
interface Asked {
  view: string;
  pixels: number;
}

/**
 * Fetches steps before they are shown, in the direction of play: first the coarse levels of the next steps, and
 * then the chunks of these steps that the view needs. Budgets of bytes and samples limit both.
 */
export class StepLoader {
  readonly #time: () => Time;
  readonly #host: StepLoaderHost;
  readonly #planning = new CoalescedTask(() => this.#plan());
  readonly #bandwidth = new Bandwidth();
  readonly #costs = new StepCosts(() => this.#host.shownField());
  readonly #asked = new WeakMap<OpenVolume, Asked>();
  /** By layer, view, step and size of cells. */
  readonly #needs = new Map<string, StepNeed>();
  readonly #failedAt = new WeakMap<OpenVolume, number>();
  #view: View | null = null;
  #viewTimer: ReturnType<typeof setTimeout> | undefined;
  /** The cell size of steps while they play. It normally does not change during playing. */
  #pixels = 1;
  #isPixelsChosen = false;
  #most = 0;
  /** The number of consecutive steps that were coarser than planned when they were shown. */
  #late = 0;

  constructor(time: () => Time, host: StepLoaderHost) {
    this.#time = time;
    this.#host = host;
  }

  get cellPixels(): number {
    return this.#pixels;
  }

  get cost(): PlayCost | undefined {
    return this.#costs.total(this.#host.entries(), this.#time().steps);
  }

  /** The size of cells of the shown step; undefined: as fine as the view needs them. */
  get shownCellPixels(): number | undefined {
    return this.#time().isPlaying ? this.#pixels : undefined;
  }

  /** Most samples of a step that is not shown. */
  samplesOf(entry: LayerEntry): number {
    return Math.floor(samplesOfOthers(entry) / Math.max(1, this.#most || 2));
  }

  /** The view that is drawn. */
  viewed(viewProjection: ArrayLike<number>, viewport: View["viewport"]): void {
    const before = this.#view;
    this.#view = { viewProjection: Array.from(viewProjection), viewport: { ...viewport } };
    if (before && keyOf(before) === keyOf(this.#view)) return;
    this.#needs.clear();
    this.#viewTimer ??= setTimeout(() => {
      this.#viewTimer = undefined;
      if (!this.#time().isPlaying) this.#isPixelsChosen = false;
      this.changed();
    }, viewInterval);
  }

  /** Something that the plan depends on has changed. */
  changed(): void {
    this.#planning.request();
  }

  /** Playing has begun or ended, or its rate has changed. */
  chooseDetail(): void {
    this.#isPixelsChosen = false;
    this.changed();
  }

  /** Whether a step has a surface. Also requests the chunks that the present view needs of it. */
  isShowable(step: number): boolean {
    const volumes = this.#host
      .entries()
      .map((entry) => ({ entry, volume: entry.steps.find(step) }));
    const isPresent = volumes.every(
      ({ volume }) => volume && (volume.error !== null || volume.session?.hasFirstSurface),
    );
    if (!isPresent) return false;
    const pixels = this.#time().isPlaying ? this.#pixels : onlyCoarse;
    for (const { entry, volume } of volumes) {
      const isAsked = volume && this.#asked.get(volume)?.view === this.#keyOf(entry);
      if (volume && !isAsked) this.#ask(entry, volume, pixels);
    }
    return true;
  }

  /**
   * Called before a step is shown. If several consecutive steps are late because of the bandwidth, the next ones
   * are fetched with less detail.
   */
  shown(step: number): void {
    const isLate = this.#time().isPlaying && !this.#isReady(this.#host.entries(), step);
    this.#late = isLate ? this.#late + 1 : 0;
    if (this.#late < lateInARow) return;
    this.#late = 0;
    this.#pixels = Math.max(this.#pixels, this.#cellPixelsThatPlay(true));
  }

  /** A volume is no longer shown. Until now, its session has received the views of the picture. */
  hidden(volume: OpenVolume): void {
    this.#asked.delete(volume);
  }

  close(): void {
    this.#planning.cancel();
    clearTimeout(this.#viewTimer);
  }

  /** Retries the steps that have failed. */
  retry(): void {
    for (const entry of this.#host.entries()) {
      for (const volume of entry.steps.volumes) this.#failedAt.delete(volume);
    }
    this.changed();
  }

  #plan(): void {
    const time = this.#time();
    const entries = this.#host.entries();
    const { step } = time;
    const wanted = time.wantedStep;
    if (wanted !== step) this.#open(entries, wanted);
    for (const entry of entries) {
      for (const each of entry.steps.present) {
        const volume = entry.steps.find(each);
        if (volume) this.#costs.note(entry, each, volume);
      }
    }
    const plan = this.#ahead(entries);
    this.#follow(entries, plan);
    this.#measure(entries, [wanted, ...plan.refined]);
    time.arrived();
  }

  #measure(entries: readonly SteppedEntry[], needed: readonly number[]): void {
    const isFetching = entries.some(({ steps }) =>
      needed.some((step) => {
        const volume = steps.find(step);
        return volume?.isOpening || (volume?.progress?.chunksToGo ?? 0) > 0;
      }),
    );
    const bytes = entries.reduce((sum, { steps }) => sum + steps.bytesReceived, 0);
    this.#bandwidth.add(performance.now(), bytes, isFetching);
  }

  #ahead(entries: readonly SteppedEntry[]): AheadPlan {
    const time = this.#time();
    const isWaiting = time.wantedStep !== time.step;
    const present = (): number[] => [...new Set(entries.flatMap(({ steps }) => steps.present))];
    // The step that is shown, or that is wanted, takes precedence.
    if (!this.#view || isWaiting || !(time.isPlaying || this.#host.isShownComplete())) {
      return { kept: present(), refined: [] };
    }
    const others = time.steps - 1;
    const ahead = stepsAhead(time.position, time.steps, time.mode);
    if (!this.#isPixelsChosen) {
      this.#isPixelsChosen = true;
      this.#pixels = this.#cellPixelsThatPlay(false);
    }
    const need = entries.map((entry) => this.#need(entry, this.#pixels));
    this.#setMost(
      entries,
      Math.min(
        others,
        ...entries.map((entry, i) =>
          stepsThatFit(samplesOfOthers(entry), need[i]?.samples ?? 0, others),
        ),
      ),
    );
    return planAhead({
      ahead,
      most: this.#most,
      byteBudget: aheadBytes,
      stepBytes: need.reduce((sum, { bytes, coarseBytes }) => sum + bytes + coarseBytes, 0),
      isReady: (each) => this.#isReady(entries, each),
      isPlaying: time.isPlaying,
    });
  }

  /** The bytes and samples that a step needs for the present view, as estimated from the step that was shown last. */
  #need(entry: SteppedEntry, pixels: number): StepNeed {
    const field = this.#host.shownField() ?? "";
    const key = `${this.#keyOf(entry)} ${this.#time().step} ${pixels} ${field}`;
    let known = this.#needs.get(key);
    if (!known) {
      known = needOf(entry, this.#viewOf(entry, pixels));
      // The directory of the step may arrive later.
      if (known && this.#host.isShownComplete()) this.#needs.set(key, known);
    }
    return known ?? { bytes: 0, coarseBytes: 0, samples: 0 };
  }

  /** Calls cellPixelsThatPlay (time_plan.ts) for the present layers and steps. */
  #cellPixelsThatPlay(isLate: boolean): number {
    const time = this.#time();
    const entries = this.#host.entries();
    const ahead = stepsAhead(time.position, time.steps, time.mode);
    const unopened = ahead.filter((step) => !entries.every(({ steps }) => steps.has(step))).length;
    const bytesAt = (pixels: number): number => {
      const missing = ahead.filter((step) => !this.#isReady(entries, step, pixels)).length;
      const bytes = entries.reduce((sum, entry) => {
        const need = this.#need(entry, pixels);
        return sum + need.bytes * missing + need.coarseBytes * unopened;
      }, 0);
      return bytes / Math.max(1, ahead.length);
    };
    return cellPixelsThatPlay(bytesAt, time.rate, this.#bandwidth.bytesPerSecond, isLate);
  }

  /** Divides the samples for steps that are not shown among the steps that are kept. */
  #setMost(entries: readonly SteppedEntry[], most: number): void {
    this.#most = most;
    for (const entry of entries) {
      const samples = this.samplesOf(entry);
      for (const volume of entry.steps.volumes) {
        if (volume !== entry.volume) volume.session?.setSampleBudget(samples);
      }
    }
  }

  #follow(entries: readonly SteppedEntry[], { kept, refined }: AheadPlan): void {
    const time = this.#time();
    const stay = new Set([time.step, time.wantedStep, ...kept]);
    for (const entry of entries) {
      for (const step of entry.steps.present) {
        if (!stay.has(step)) this.#host.close(entry, step);
      }
    }
    for (const step of kept) this.#open(entries, step);
    for (const entry of entries) {
      for (const step of kept) {
        const volume = entry.steps.find(step);
        if (!volume || volume === entry.volume) continue;
        if (refined.includes(step)) this.#ask(entry, volume, this.#pixels);
        else if (!this.#isReady([entry], step)) this.#ask(entry, volume, onlyCoarse);
      }
    }
  }

  #open(entries: readonly SteppedEntry[], step: number): void {
    for (const entry of entries) {
      const isWanted = step === this.#time().wantedStep;
      const opening = entry.steps.volumes.filter(({ isOpening }) => isOpening).length;
      if (!isWanted && opening >= openedTogether) return;
      const volume = entry.steps.find(step);
      if (volume && (volume.session || volume.isOpening || !this.#mayRetry(volume))) continue;
      void this.#host.open(entry, step).then(() => this.changed());
    }
  }

  /** If a store cannot be opened, it is retried after a while. */
  #mayRetry(volume: OpenVolume): boolean {
    if (volume.error === null) return true;
    const now = performance.now();
    const failedAt = this.#failedAt.get(volume);
    if (failedAt === undefined) this.#failedAt.set(volume, now);
    else if (now - failedAt < slowRetry) return false;
    else this.#failedAt.delete(volume);
    return failedAt !== undefined;
  }

  /** Requests the chunks that the view needs of a step that is not shown. */
  #ask(entry: SteppedEntry, volume: OpenVolume, pixels: number): void {
    if (!volume.session || !this.#view) return;
    const view = this.#viewOf(entry, pixels);
    const key = this.#keyOf(entry);
    const before = this.#asked.get(volume);
    if (before?.view === key && before.pixels === pixels) return;
    this.#asked.set(volume, { view: key, pixels });
    volume.session.update(view);
  }

  #viewOf(entry: SteppedEntry, pixels: number): CameraView {
    const { viewProjection, viewport } = this.#view ?? { viewProjection: [], viewport: noSize };
    return {
      viewProjection: viewProjectionOf(Float64Array.from(viewProjection), entry.layer.transform),
      viewport,
      isovalues: isovaluesOf(entry),
      moving: false,
      stepCellPixels: pixels,
    };
  }

  /** Distinguishes pictures in which a layer needs other chunks. */
  #keyOf(entry: SteppedEntry): string {
    const { transform } = entry.layer;
    const view = this.#view ? keyOf(this.#view) : "";
    return `${entry.layer.id} ${view} ${isovaluesOf(entry)} ${transform}`;
  }

  /** Whether a step has the detail with which it is to be played. True for a step that cannot be opened. */
  #isReady(entries: readonly SteppedEntry[], step: number, pixels = this.#pixels): boolean {
    return entries.every((entry) => {
      const volume = entry.steps.find(step);
      if (!volume) return false;
      if (volume.error !== null) return true;
      const { progress } = volume;
      if (!progress || isStreaming(progress)) return false;
      if (volume === entry.volume) return true;
      const asked = this.#asked.get(volume);
      return asked !== undefined && asked.view === this.#keyOf(entry) && asked.pixels <= pixels;
    });
  }
}

const noSize = { width: 1, height: 1 };

function keyOf({ viewProjection, viewport }: View): string {
  return `${Array.from(viewProjection)} ${viewport.width} ${viewport.height}`;
}
