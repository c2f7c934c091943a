import type { KeptBytes } from "../stream/kept_bytes.ts";
import { KeptSource } from "../stream/kept_source.ts";
import type { Source } from "../stream/source.ts";
import type { OpenVolume } from "./open_volume.ts";

/** Makes the source of a step's store. */
export type StepSources = (step: number) => Source;

/**
 * The volumes of a layer that has a store for each step. A volume is made when it is needed. A step that was
 * closed keeps its source, which may still have the bytes, so that opening it again needs no request.
 */
export class LayerSteps {
  readonly #sourceOf: StepSources;
  readonly #kept: KeptBytes;
  readonly #make: (step: number, source: Source) => OpenVolume;
  readonly #sources = new Map<number, KeptSource>();
  readonly #volumes = new Map<number, OpenVolume>();

  constructor(
    sourceOf: StepSources,
    kept: KeptBytes,
    make: (step: number, source: Source) => OpenVolume,
  ) {
    this.#sourceOf = sourceOf;
    this.#kept = kept;
    this.#make = make;
  }

  /** The volumes that were made, and not closed. */
  get volumes(): OpenVolume[] {
    return [...this.#volumes.values()];
  }

  /** Their steps. */
  get present(): number[] {
    return [...this.#volumes.keys()];
  }

  /** Of all sources that were made. */
  get bytesReceived(): number {
    return [...this.#sources.values()].reduce((sum, source) => sum + source.bytesReceived, 0);
  }

  has(step: number): boolean {
    return this.#volumes.has(step);
  }

  /** Undefined unless it was made. */
  find(step: number): OpenVolume | undefined {
    return this.#volumes.get(step);
  }

  at(step: number): OpenVolume {
    let volume = this.#volumes.get(step);
    if (!volume) {
      volume = this.#make(step, this.#source(step));
      this.#volumes.set(step, volume);
    }
    return volume;
  }

  #source(step: number): KeptSource {
    let source = this.#sources.get(step);
    if (!source) {
      source = new KeptSource(this.#sourceOf(step), this.#kept);
      this.#sources.set(step, source);
    }
    return source;
  }

  /** Closes the volume of a step, and frees its samples. Returns it. */
  close(step: number): OpenVolume | undefined {
    const volume = this.#volumes.get(step);
    this.#volumes.delete(step);
    volume?.close();
    return volume;
  }

  /** Closes all volumes except this one, and returns the closed ones. */
  closeOthers(shown: OpenVolume): OpenVolume[] {
    const others = this.present.filter((step) => this.#volumes.get(step) !== shown);
    return others.flatMap((step) => this.close(step) ?? []);
  }
}
