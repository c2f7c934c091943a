import { CoreError } from "../core/calls.ts";
import { textAt } from "../core/text.ts";
import type { BuilderModule } from "./module.ts";
import type { BuildLimits, BuildReport, VolumeDescription } from "./types.ts";

/** The values of ISOSPLAT_NEXT_… in shared/bindings/wasm/builder_api.h. */
const nextTask = 0;
const nextComplete = 2;

/**
 * One IsosplatBuilder: it directs a build (begin, next, add, addStatistics, finish), or encodes blocks
 * (setUp, encode, statistics). Results are copies. Throws a CoreError when a call fails.
 */
export class Builder {
  readonly #module: BuilderModule;
  #builder: number;

  constructor(module: BuilderModule) {
    this.#module = module;
    this.#builder = module._isosplat_builder_create();
  }

  /** Reads the value range and a sample of the volume. Returns the setup of the encoders. */
  begin(volume: VolumeDescription, limits: BuildLimits = {}): Uint8Array {
    // JSON.stringify writes -0 as 0, which would change the bytes of the store.
    const json = JSON.stringify({ ...volume, ...limits }, (_, value) =>
      Object.is(value, -0) ? "-0" : value,
    );
    const text = new TextEncoder().encode(json);
    this.#call(text, (at) =>
      this.#module._isosplat_builder_begin(this.#builder, at, text.byteLength),
    );
    return this.#result();
  }

  /**
   * The next task for an encoder; `wait` if a block must be added first; `complete` if all blocks were
   * added. Reads slices when a layer of blocks begins.
   */
  next(): Uint8Array | "wait" | "complete" {
    this.#check(this.#module._isosplat_builder_next(this.#builder));
    const next = this.#result(1)[0];
    if (next === nextTask) return this.#result();
    return next === nextComplete ? "complete" : "wait";
  }

  /** Adds a block that an encoder has encoded. */
  add(block: Uint8Array): void {
    this.#call(block, (at) =>
      this.#module._isosplat_builder_add(this.#builder, at, block.byteLength),
    );
  }

  addStatistics(statistics: Uint8Array): void {
    this.#call(statistics, (at) =>
      this.#module._isosplat_builder_add_statistics(this.#builder, at, statistics.byteLength),
    );
  }

  finish(): BuildReport {
    this.#check(this.#module._isosplat_builder_finish(this.#builder));
    return JSON.parse(new TextDecoder().decode(this.#result())) as BuildReport;
  }

  setUp(setup: Uint8Array): void {
    this.#call(setup, (at) =>
      this.#module._isosplat_builder_set_up(this.#builder, at, setup.byteLength),
    );
  }

  encode(task: Uint8Array): Uint8Array {
    this.#call(task, (at) =>
      this.#module._isosplat_builder_encode(this.#builder, at, task.byteLength),
    );
    return this.#result();
  }

  statistics(): Uint8Array {
    this.#check(this.#module._isosplat_builder_statistics(this.#builder));
    return this.#result();
  }

  close(): void {
    this.#module._isosplat_builder_destroy(this.#builder);
    this.#builder = 0;
  }

  #call(bytes: Uint8Array, call: (at: number) => number): void {
    const at = this.#module._malloc(Math.max(1, bytes.byteLength));
    if (at === 0) throw new CoreError("out_of_memory", "the browser gives no more memory");
    try {
      this.#module.HEAPU8.set(bytes, at);
      this.#check(call(at));
    } finally {
      this.#module._free(at);
    }
  }

  #result(buffer = 0): Uint8Array {
    const at = this.#module._isosplat_builder_result(this.#builder, buffer);
    const bytes = this.#module._isosplat_builder_result_bytes(this.#builder, buffer);
    return this.#module.HEAPU8.slice(at, at + bytes);
  }

  #check(status: number): void {
    if (status === 0) return;
    const { _isosplat_builder_status_name: name, _isosplat_builder_error: error } = this.#module;
    throw new CoreError(
      textAt(this.#module, name(status)),
      textAt(this.#module, error(this.#builder)),
    );
  }
}
