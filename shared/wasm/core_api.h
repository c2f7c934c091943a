#pragma once

#include <stddef.h>
#include <stdint.h>

/// The core for JavaScript: reading a store, decoding chunks, projecting samples, and choosing what
/// a view needs. Exported by the modules `isosplat-core` and `isosplat-renderer`; web/core wraps
/// it.
///
/// Rules. A `Core` is one open store, or just a decoder; it is used by one thread. Functions that
/// return uint32_t `status` return a Status (0: ok), and isosplat_core_error() then says what went
/// wrong. Bytes that a function reads are the caller's (malloc and free are exported) and need hold
/// only during the call. What a function yields lies in one of the core's result buffers until the
/// core's next call. Any call may grow the heap: re-read memory.buffer after it.
///
/// Quantized isovalues are quantized values as `float` (StoreInfo: value = offset + scale ·
/// quantized value).
#ifdef __cplusplus
extern "C" {
#endif

typedef struct IsosplatCore IsosplatCore;

/// A chunk: ChunkRef and its handle, 56 bytes.
typedef struct IsosplatChunk {
  double offset;    ///< in the file
  uint32_t handle;  ///< a small number that stays the same as long as the store is open
  uint32_t level;
  uint32_t block[3];
  uint32_t band;
  uint32_t band_begin, band_end;
  uint32_t bytes;
  uint32_t cells;
  uint32_t checksum;
  uint32_t block_cells;  ///< x | y << 8 | z << 16
} IsosplatChunk;

/// A directory page, 40 bytes.
typedef struct IsosplatPage {
  double offset;  ///< in the file
  uint32_t bytes;
  uint32_t level;
  uint32_t first_block[3];
  uint32_t resident;  ///< 0 or 1
  uint32_t interval_min, interval_max;
} IsosplatPage;

IsosplatCore* isosplat_core_create(void);
void isosplat_core_destroy(IsosplatCore* core);

/// The last error's message, and a status' name: UTF-8, null-terminated.
const char* isosplat_core_error(const IsosplatCore* core);
const char* isosplat_core_status_name(uint32_t status);

/// Result buffer 0 … 3, and its size in bytes.
const void* isosplat_core_result(const IsosplatCore* core, uint32_t buffer);
uint32_t isosplat_core_result_bytes(const IsosplatCore* core, uint32_t buffer);

/// Opens a store from its first min(64 KiB, file size) bytes. See StoreReader::open.
uint32_t isosplat_core_open(IsosplatCore* core, const void* header, uint32_t bytes);

/// Result 0: 29 doubles: voxels x y z, spacing x y z, origin x y z, direction (9), offset, scale,
/// max_error, bits, has_missing, lowest quantized value, highest quantized value, levels,
/// chunk_count, missing_voxels, file_bytes. Result 1: content id, 16 bytes. Result 2: metadata,
/// JSON text.
uint32_t isosplat_core_info(IsosplatCore* core);

/// ValueMapping::quantized_isovalue; NaN where no store is open.
float isosplat_core_quantized_isovalue(const IsosplatCore* core, double isovalue);

/// The coarse tail of the file, at most max_bytes (StoreReader::coarse_range). Result 0: 3 doubles:
/// first level, offset, bytes.
uint32_t isosplat_core_coarse_range(IsosplatCore* core, double max_bytes);

/// What to read first (StoreReader::bootstrap_range), as above.
uint32_t isosplat_core_bootstrap_range(IsosplatCore* core);

/// Result 0: IsosplatPage of every page.
uint32_t isosplat_core_pages(IsosplatCore* core);
uint32_t isosplat_core_add_page(IsosplatCore* core, uint32_t page, const void* data,
                                uint32_t bytes);

/// Result 0: page numbers (uint32) that chunks_for of the same arguments needs and that are
/// missing.
uint32_t isosplat_core_missing_pages(IsosplatCore* core, uint32_t level, float low, float high);

/// Result 0: IsosplatChunk of every chunk of a level that meets [low, high], in file order.
uint32_t isosplat_core_chunks_for(IsosplatCore* core, uint32_t level, float low, float high);

/// Low 32 bits of XXH3-64: what a chunk's directory entry records of its bytes.
uint32_t isosplat_core_checksum(const void* data, uint32_t bytes);

/// Decodes a chunk for the GPU. `shape` has 7 words: block_cells x y z, band_begin, band_end,
/// cells, level. Needs no open store. Result 0: PackedSample, 16 bytes each.
uint32_t isosplat_core_decode_packed(IsosplatCore* core, const void* data, uint32_t bytes,
                                     const uint32_t* shape);

/// Decodes a chunk of the open store to samples at the centres of its cells. `shape` as above,
/// `block` the block's index. Results, one entry per cell: 0: world position (3 floats), 1: value
/// (float), 2: gradient in values per world unit (3 floats), 3: interval, lowest and highest value
/// (2 floats).
uint32_t isosplat_core_decode_samples(IsosplatCore* core, const void* data, uint32_t bytes,
                                      const uint32_t* shape, const uint32_t* block);

/// Projects the chunk's active samples onto an isosurface: one point for each, inside of its cell.
/// `exact` 0: one Newton step, as far as the displacement threshold allows, 1: along the gradient
/// to the trilinear surface in the cell, or one Newton step where it is not met. Results: 0: world
/// position (3 floats), 1: unit normal, the negative gradient's direction (3 floats).
uint32_t isosplat_core_project(IsosplatCore* core, const void* data, uint32_t bytes,
                               const uint32_t* shape, const uint32_t* block,
                               float quantized_isovalue, uint32_t exact);

/// The same of samples as isosplat_core_decode_packed yields them, `count` of the block `block` of
/// a level, as far as they lie in `regions` (16 words, RegionMask; null: all). Points are as near
/// to the isosurface as packing leaves the corners (PackedSample).
uint32_t isosplat_core_project_packed(IsosplatCore* core, const void* samples, uint32_t count,
                                      const uint32_t* regions, uint32_t level,
                                      const uint32_t* block, float quantized_isovalue,
                                      uint32_t exact);

/// Chooses what a view needs (Selector). `view` has 23 doubles: view_projection (16,
/// column-major), width_px, height_px, load_cell_px, draw_cell_px, cell_budget, ahead (1: only
/// expected, see select_ahead), occlusion (0 or 1). Results: 0: IsosplatChunk to load, 1: pages to
/// load (uint32), 2: chunks to draw, 17 words each: handle, regions (RegionMask); 3: five words:
/// finest drawn level, coarsest drawn level (−1: none), limited_by_budget, undecided, count of the
/// handles to test, which follow, and after them the handles to keep.
uint32_t isosplat_core_select(IsosplatCore* core, const double* view,
                              const float* quantized_isovalues, uint32_t isovalue_count);

/// The answer of an occlusion query for the view selected last (Selector::set_visibility): 33 words
/// for each chunk: handle, the regions tested, those of them that may be seen.
uint32_t isosplat_core_set_visibility(IsosplatCore* core, const uint32_t* answer, uint32_t count);

/// Says that a chunk may be drawn, or no longer may.
uint32_t isosplat_core_set_resident(IsosplatCore* core, uint32_t handle, uint32_t resident);

#ifdef __cplusplus
}
#endif
