/**
 * The functions of shared/bindings/wasm/core_api.h, where they are documented. The modules isosplat-core and
 * isosplat-renderer export them.
 */
export interface CoreModule {
  /** Valid until the next call into the module, which may grow the heap and replace this. */
  HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(pointer: number): void;
  _isosplat_core_create(): number;
  _isosplat_core_destroy(core: number): void;
  _isosplat_core_error(core: number): number;
  _isosplat_core_status_name(status: number): number;
  _isosplat_core_result(core: number, buffer: number): number;
  _isosplat_core_result_bytes(core: number, buffer: number): number;
  _isosplat_core_check_bundle(core: number, header: number, bytes: number): number;
  _isosplat_core_open(core: number, header: number, bytes: number): number;
  _isosplat_core_open_field(core: number, header: number, bytes: number): number;
  _isosplat_core_info(core: number): number;
  _isosplat_core_coarse_range(core: number, maxBytes: number): number;
  _isosplat_core_bootstrap_range(core: number): number;
  _isosplat_core_pages(core: number): number;
  _isosplat_core_add_page(core: number, page: number, data: number, bytes: number): number;
  _isosplat_core_missing_pages(core: number, level: number, low: number, high: number): number;
  _isosplat_core_chunks_for(core: number, level: number, low: number, high: number): number;
  _isosplat_core_chunk_at(core: number, level: number, block: number, band: number): number;
  _isosplat_core_checksum(data: number, bytes: number): number;
  _isosplat_core_decode_packed(core: number, data: number, bytes: number, shape: number): number;
  _isosplat_core_decode_chunk(
    core: number,
    data: number,
    bytes: number,
    shape: number,
    checksum: number,
  ): number;
  _isosplat_core_decode_field(
    core: number,
    data: number,
    bytes: number,
    shape: number,
    checksum: number,
    samples: number,
    count: number,
    bits: number,
  ): number;
  _isosplat_core_decode_samples(core: number, data: number, bytes: number, shape: number): number;
  _isosplat_core_project(
    core: number,
    data: number,
    bytes: number,
    shape: number,
    quantizedIsovalue: number,
    exact: number,
  ): number;
  _isosplat_core_project_packed(
    core: number,
    samples: number,
    count: number,
    regions: number,
    block: number,
    quantizedIsovalue: number,
    exact: number,
  ): number;
  _isosplat_core_set_spacing(core: number, x: number, y: number, z: number): number;
  _isosplat_core_quantized_isovalue(core: number, isovalue: number): number;
  _isosplat_core_select(
    core: number,
    view: number,
    quantizedIsovalues: number,
    count: number,
  ): number;
  _isosplat_core_set_visibility(core: number, answers: number, count: number): number;
  _isosplat_core_set_resident(core: number, handle: number, resident: number): number;
}
