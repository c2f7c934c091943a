import { CoreError } from "../core/calls.ts";
import { textAt } from "../core/text.ts";
import type { ImportModule } from "./module.ts";
import {
  ChoiceError,
  type ImportedVolume,
  type ImportOptions,
  type Packing,
  type VolumeChoice,
} from "./types.ts";

/** The most bytes that are read at a time. They take additional memory in the importer. */
const readBytes = 16 << 20;

/** One IsosplatImport. Throws a CoreError when a call fails. */
export class Importer {
  readonly #module: ImportModule;
  #importer: number;

  constructor(module: ImportModule) {
    this.#module = module;
    this.#importer = module._isosplat_import_create();
  }

  /** The format of a file by its first bytes and its name; "" if no reader takes it. */
  detect(path: string): string {
    this.#call(path, (at, bytes) =>
      this.#module._isosplat_import_detect(this.#importer, at, bytes),
    );
    return this.#text();
  }

  /** How a file is compressed, if it must be unpacked before it is opened. */
  packing(path: string): Packing | undefined {
    this.#call(path, (at, bytes) =>
      this.#module._isosplat_import_packing(this.#importer, at, bytes),
    );
    return (this.#text() || undefined) as Packing | undefined;
  }

  /** The volumes of a file that has several; empty if no choice is needed. */
  choices(path: string): VolumeChoice[] {
    this.#call(path, (at, bytes) =>
      this.#module._isosplat_import_choices(this.#importer, at, bytes),
    );
    return JSON.parse(this.#text()) as VolumeChoice[];
  }

  /** Throws a ChoiceError if there are several volumes and the options choose none. */
  open(path: string, options: ImportOptions = {}): ImportedVolume {
    const request = JSON.stringify({ path, options });
    try {
      this.#call(request, (at, bytes) =>
        this.#module._isosplat_import_open(this.#importer, at, bytes),
      );
    } catch (error) {
      if (!(error instanceof CoreError) || error.status === "out_of_memory") throw error;
      const choices = JSON.parse(this.#text()) as VolumeChoice[];
      throw choices.length > 0 ? new ChoiceError(error.status, error.message, choices) : error;
    }
    return JSON.parse(this.#text()) as ImportedVolume;
  }

  /** Fills `into` with slices: `into` has exactly `count` of them. */
  readSlices(first: number, count: number, into: Uint8Array): void {
    const sliceBytes = into.byteLength / count;
    const most = Math.max(1, Math.floor(readBytes / sliceBytes));
    for (let done = 0; done < count; done += most) {
      const some = Math.min(most, count - done);
      this.#check(this.#module._isosplat_import_read_slices(this.#importer, first + done, some));
      into.set(this.#result(), done * sliceBytes);
    }
  }

  close(): void {
    this.#module._isosplat_import_destroy(this.#importer);
    this.#importer = 0;
  }

  #call(text: string, call: (at: number, bytes: number) => number): void {
    const bytes = new TextEncoder().encode(text);
    const at = this.#module._malloc(Math.max(1, bytes.byteLength));
    if (at === 0) throw new CoreError("out_of_memory", "the browser gives no more memory");
    try {
      this.#module.HEAPU8.set(bytes, at);
      this.#check(call(at, bytes.byteLength));
    } finally {
      this.#module._free(at);
    }
  }

  /** A view, until the next call. */
  #result(): Uint8Array {
    const at = this.#module._isosplat_import_result(this.#importer);
    const bytes = this.#module._isosplat_import_result_bytes(this.#importer);
    return this.#module.HEAPU8.subarray(at, at + bytes);
  }

  #text(): string {
    return new TextDecoder().decode(this.#result().slice());
  }

  #check(status: number): void {
    if (status === 0) return;
    const { _isosplat_import_status_name: name, _isosplat_import_error: error } = this.#module;
    throw new CoreError(
      textAt(this.#module, name(status)),
      textAt(this.#module, error(this.#importer)),
    );
  }
}
