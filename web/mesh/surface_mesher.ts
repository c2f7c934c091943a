import * as layouts from "../../build/wasm/web/layouts.js";
import { BlobParts } from "../core/blob_parts.ts";
import { CoreError } from "../core/calls.ts";
import type { CompiledModule } from "../core/instantiate.ts";
import { type Chunk, volumeRecord } from "../core/records.ts";
import { textAt } from "../core/text.ts";
import { instantiateMesh, type MeshModule } from "./module.ts";
import { type FileJob, type MeshJob, type MeshResult, meshFormats } from "./types.ts";

/** The result buffers of mesh_api.h. */
const bodyBuffer = 0;
const tailBuffer = 1;
const headerBuffer = 2;
const numbersBuffer = 3;

/** Statuses of a chunk with damaged bytes, which can be fetched again. */
const damaged = new Set(["checksum_mismatch", "malformed_chunk", "truncated"]);

/** Runs a job on the calling thread, with a separate module instance. Throws CoreErrors. */
export class SurfaceMesher {
  readonly #module: MeshModule;
  readonly #isFile: boolean;
  readonly #body = new BlobParts();
  readonly #tail = new BlobParts();

  private constructor(module: MeshModule, job: MeshJob) {
    this.#module = module;
    this.#isFile = job.kind === "file";
  }

  static async begin(program: CompiledModule, job: MeshJob): Promise<SurfaceMesher> {
    const module = await instantiateMesh(program);
    const mesher = new SurfaceMesher(module, job);
    mesher.#begin(job);
    return mesher;
  }

  #begin(job: MeshJob): void {
    const { info, quantizedIsovalue } = job;
    const volume = new Uint8Array(layouts.volumeBytes);
    layouts.writeVolume(new DataView(volume.buffer), 0, volumeRecord(info));
    this.#withBytes(volume, (at) => {
      if (job.kind === "file") this.#beginFile(at, job);
      else {
        const [lowest] = info.quantizedRange;
        this.#check(this.#module._isosplat_mesh_begin_extent(at, quantizedIsovalue, lowest));
      }
    });
  }

  #beginFile(volume: number, job: FileJob) {
    const { info, quantizedIsovalue, level, format, comment, box, closed, planes } = job;
    const module = this.#module;
    const text = new TextEncoder().encode(comment);
    this.#withBytes(text, (at) =>
      this.#check(
        module._isosplat_mesh_begin_file(
          volume,
          level,
          quantizedIsovalue,
          meshFormats.indexOf(format),
          at,
          text.length,
        ),
      ),
    );
    if (!box && !closed) return;
    // A side of the box at the volume's border does not clip: coarse cells may reach beyond the
    // last voxel.
    const { low, high } = box ?? { low: [0, 0, 0], high: [1, 1, 1] };
    const from = low.map((n, i) => (n <= 0 ? -Infinity : n * ((info.voxels[i] ?? 1) - 1)));
    const to = high.map((n, i) => (n >= 1 ? Infinity : n * ((info.voxels[i] ?? 1) - 1)));
    const corners = new Uint8Array(Float64Array.from([...from, ...to]).buffer);
    if (!closed) {
      this.#withBytes(corners, (at) => this.#check(module._isosplat_mesh_set_region(at)));
      return;
    }
    const numbers = planes.flatMap(({ normal, offset }) => [...normal, offset]);
    this.#withBytes(corners, (boxAt) =>
      this.#withBytes(new Uint8Array(Float64Array.from(numbers).buffer), (at) =>
        this.#check(module._isosplat_mesh_close(boxAt, at, planes.length)),
      ),
    );
  }

  /**
   * Adds a chunk of the level: for a file, in ascending order by z, then y, then x. Returns false
   * if its bytes are damaged.
   */
  add(chunk: Chunk, bytes: Uint8Array): boolean {
    const module = this.#module;
    const shape = new Uint8Array(layouts.chunkShapeBytes);
    layouts.writeChunkShape(new DataView(shape.buffer), 0, chunk);
    const status = this.#withBytes(shape, (shapeAt) =>
      this.#withBytes(bytes, (at) =>
        module._isosplat_mesh_add(at, bytes.length, shapeAt, chunk.checksum),
      ),
    );
    if (damaged.has(textAt(module, module._isosplat_mesh_status_name(status)))) return false;
    this.#check(status);
    this.#encode();
    return true;
  }

  finish(): MeshResult {
    this.#check(this.#module._isosplat_mesh_finish());
    this.#encode();
    this.#check(this.#module._isosplat_mesh_summary());
    const numbers = new Float64Array(this.#result(numbersBuffer).buffer);
    const [first = 0, second = 0, third = 0] = numbers;
    return {
      numbers: [first, second, third],
      ...(this.#isFile && {
        file: new Blob([
          this.#result(headerBuffer) as BlobPart,
          this.#body.blob(),
          this.#tail.blob(),
        ]),
      }),
    };
  }

  /** Takes the bytes of the completed parts. */
  #encode(): void {
    while (this.#module._isosplat_mesh_parts_left() > 0) {
      this.#check(this.#module._isosplat_mesh_encode_part());
      this.#body.add(this.#result(bodyBuffer));
      this.#tail.add(this.#result(tailBuffer));
    }
  }

  /** A copy of a result buffer. */
  #result(buffer: number): Uint8Array {
    const at = this.#module._isosplat_mesh_result(buffer);
    const bytes = this.#module._isosplat_mesh_result_bytes(buffer);
    return this.#module.HEAPU8.slice(at, at + bytes);
  }

  #withBytes<T>(bytes: Uint8Array, use: (at: number) => T): T {
    const at = this.#module._malloc(Math.max(1, bytes.length));
    if (at === 0) throw new CoreError("out_of_memory", "the browser gives no more memory");
    try {
      this.#module.HEAPU8.set(bytes, at);
      return use(at);
    } finally {
      this.#module._free(at);
    }
  }

  #check(status: number): void {
    if (status === 0) return;
    const module = this.#module;
    throw new CoreError(
      textAt(module, module._isosplat_mesh_status_name(status)),
      textAt(module, module._isosplat_mesh_error()),
    );
  }
}
