import { fileBytes } from "../core/file_bytes.ts";
import { type CompiledModule, instantiate, type ModuleFactory } from "../core/instantiate.ts";

/** The exports of isosplat-mesh.wasm: shared/wasm/mesh_api.h. */
export interface MeshModule {
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(at: number): void;
  _isosplat_mesh_error(): number;
  _isosplat_mesh_status_name(status: number): number;
  _isosplat_mesh_result(buffer: number): number;
  _isosplat_mesh_result_bytes(buffer: number): number;
  _isosplat_mesh_begin_extent(volume: number, quantizedIsovalue: number, lowest: number): number;
  _isosplat_mesh_begin_file(
    volume: number,
    level: number,
    quantizedIsovalue: number,
    format: number,
    comment: number,
    commentBytes: number,
  ): number;
  _isosplat_mesh_set_region(box: number): number;
  _isosplat_mesh_add(data: number, bytes: number, shape: number, checksum: number): number;
  _isosplat_mesh_parts_left(): number;
  _isosplat_mesh_encode_part(): number;
  _isosplat_mesh_finish(): number;
  _isosplat_mesh_summary(): number;
}

let compiled: Promise<CompiledModule> | null = null;

/** Compiles the module once; a failure is tried again by the next call. */
export function compileMesh(): Promise<CompiledModule> {
  const url = new URL("../../build/wasm/web/isosplat-mesh.wasm", import.meta.url);
  compiled ??= bytesAt(url)
    .then((bytes) => WebAssembly.compile(bytes as BufferSource))
    .catch((error) => {
      compiled = null;
      throw error;
    });
  return compiled;
}

async function bytesAt(url: URL): Promise<Uint8Array | ArrayBuffer> {
  const file = await fileBytes(url);
  if (file) return file;
  const response = await fetch(url);
  if (!response.ok) throw new Error(`the module for meshes: status ${response.status}`);
  return response.arrayBuffer();
}

export async function instantiateMesh(program: CompiledModule): Promise<MeshModule> {
  const { default: factory } = await import("../../build/wasm/web/isosplat-mesh.js");
  return instantiate<MeshModule>(factory as ModuleFactory, program);
}
