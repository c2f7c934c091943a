import { type CompiledModule, instantiate, type ModuleFactory } from "../core/instantiate.ts";

/** The exports of isosplat-mesh.wasm: shared/bindings/wasm/mesh_api.h. */
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
  _isosplat_mesh_close(box: number, planes: number, planeCount: number): number;
  _isosplat_mesh_add(data: number, bytes: number, shape: number, checksum: number): number;
  _isosplat_mesh_parts_left(): number;
  _isosplat_mesh_encode_part(): number;
  _isosplat_mesh_finish(): number;
  _isosplat_mesh_summary(): number;
}

export async function instantiateMesh(program: CompiledModule): Promise<MeshModule> {
  const { default: factory } = await import("../../build/wasm/web/isosplat-mesh.js");
  return instantiate<MeshModule>(factory as ModuleFactory, program);
}
