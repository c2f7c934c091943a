#pragma once

#include <stdint.h>

#include "shared/bindings/wasm/records.h"

/// The core for JavaScript: reads a store, decodes chunks, projects samples, and selects the chunks
/// that a camera view needs. The modules `isosplat-core` and `isosplat-renderer` export these
/// functions; web/core wraps them.
///
/// Rules:
/// - An IsosplatCore is one open store, or a decoder without a store. One thread uses it.
/// - A function that can fail returns an IsosplatStatus, and never anything else: 0 is ok, any
///   other number is a Status. After a failure isosplat_core_error() returns the message.
/// - Values are returned in result buffers, or through pointers to records (records.h). Result
///   buffers belong to the core and stay valid until its next call.
/// - Memory that a function reads belongs to the caller (malloc and free are exported). The
///   function does not keep pointers to it.
/// - Every call may grow the heap: read memory.buffer again after it.
///
/// Quantized isovalues are `float`: value = value_offset + value_scale · quantized value.
#ifdef __cplusplus
extern "C" {
#endif

typedef struct IsosplatCore IsosplatCore;

/// A Status; 0: ok.
typedef uint32_t IsosplatStatus;

/// The numbers of the result buffers, for functions that fill more than one.
enum { ISOSPLAT_INFO_RECORD, ISOSPLAT_INFO_METADATA, ISOSPLAT_INFO_FIELDS };
enum {
  ISOSPLAT_SAMPLES_POSITIONS,
  ISOSPLAT_SAMPLES_VALUES,
  ISOSPLAT_SAMPLES_GRADIENTS,
  ISOSPLAT_SAMPLES_INTERVALS
};
enum { ISOSPLAT_DECODED_SAMPLES, ISOSPLAT_DECODED_CLUSTERS };
enum { ISOSPLAT_POINTS_POSITIONS, ISOSPLAT_POINTS_NORMALS };
enum {
  ISOSPLAT_SELECTION_HEADER,
  ISOSPLAT_SELECTION_LOAD,
  ISOSPLAT_SELECTION_PAGES,
  ISOSPLAT_SELECTION_DRAW,
  ISOSPLAT_SELECTION_TEST,
  ISOSPLAT_SELECTION_KEEP,
  ISOSPLAT_RESULT_BUFFERS  ///< how many buffers there are
};

IsosplatCore* isosplat_core_create(void);
void isosplat_core_destroy(IsosplatCore* core);

/// The message of the last error, and the name of a status: UTF-8, null-terminated.
const char* isosplat_core_error(const IsosplatCore* core);
const char* isosplat_core_status_name(IsosplatStatus status);

/// A result buffer, and its size in bytes. Null and 0 for a number ≥ ISOSPLAT_RESULT_BUFFERS.
const void* isosplat_core_result(const IsosplatCore* core, uint32_t buffer);
uint32_t isosplat_core_result_bytes(const IsosplatCore* core, uint32_t buffer);

/// Checks the header of a bundle (shared/core/scene/BUNDLE.md) from its first bytes:
/// parse_bundle_header. `bytes` may be more than the header. After ok, its fields can be read
/// without further checks. Needs no open store.
IsosplatStatus isosplat_core_check_bundle(IsosplatCore* core, const void* header, uint32_t bytes);

/// Opens a store from its first min(kMaxHeaderBytes, file size) bytes: StoreReader::open.
IsosplatStatus isosplat_core_open(IsosplatCore* core, const void* header, uint32_t bytes);

/// Opens a field of a store, from the first bytes of the field: StoreReader::open of
/// StoreKind::field. Its directory is read like that of a store.
IsosplatStatus isosplat_core_open_field(IsosplatCore* core, const void* header, uint32_t bytes);

/// Replaces the spacing of the open store: StoreReader::set_spacing. Call it before the functions
/// that select.
IsosplatStatus isosplat_core_set_spacing(IsosplatCore* core, double x, double y, double z);

/// Results: IsosplatStoreInfo, the metadata as JSON text, and an IsosplatField for each field.
IsosplatStatus isosplat_core_info(IsosplatCore* core);

/// Result 0: a float, ValueMapping::quantized_isovalue.
IsosplatStatus isosplat_core_quantized_isovalue(IsosplatCore* core, double isovalue);

/// The coarse tail of the file, at most max_bytes: StoreReader::coarse_range. Result 0:
/// IsosplatCoarseRange.
IsosplatStatus isosplat_core_coarse_range(IsosplatCore* core, double max_bytes);

/// The bytes to fetch first: StoreReader::bootstrap_range. Result 0: IsosplatCoarseRange.
IsosplatStatus isosplat_core_bootstrap_range(IsosplatCore* core);

/// Result 0: an IsosplatPage for every page.
IsosplatStatus isosplat_core_pages(IsosplatCore* core);
IsosplatStatus isosplat_core_add_page(IsosplatCore* core, uint32_t page, const void* data,
                                      uint32_t bytes);

/// Result 0: the numbers (uint32_t) of the pages that chunks_for needs for the same arguments and
/// that are not resident.
IsosplatStatus isosplat_core_missing_pages(IsosplatCore* core, uint32_t level, float low,
                                           float high);

/// Result 0: an IsosplatChunk for every chunk of the level whose band meets [low, high], in file
/// order.
IsosplatStatus isosplat_core_chunks_for(IsosplatCore* core, uint32_t level, float low, float high);

/// A chunk by its block (3 words) and band: StoreReader::chunk. Result 0: an IsosplatChunk; after
/// page_not_resident the number (uint32_t) of the page that describes the block.
IsosplatStatus isosplat_core_chunk_at(IsosplatCore* core, uint32_t level, const uint32_t* block,
                                      uint32_t band);

/// The low 32 bits of XXH3-64. The directory of a store holds this checksum for each chunk.
uint32_t isosplat_core_checksum(const void* data, uint32_t bytes);

/// Decodes a chunk for the GPU. Needs no open store. Result 0: PackedSample[shape->cells].
IsosplatStatus isosplat_core_decode_packed(IsosplatCore* core, const void* data, uint32_t bytes,
                                           const IsosplatChunkShape* shape);

/// Checks and decodes a chunk for the renderer. Needs no open store. `checksum` is that of the
/// directory; if isosplat_core_checksum returns another one, the status is checksum_mismatch.
/// Results: PackedSample[shape->cells] sorted by region, at coarse levels with neighbour bits;
/// SampleCluster of each region that has samples, for isosplat_renderer_reserve_chunk.
IsosplatStatus isosplat_core_decode_chunk(IsosplatCore* core, const void* data, uint32_t bytes,
                                          const IsosplatChunkShape* shape, uint32_t checksum);

/// Checks and decodes a field chunk for the renderer: decode_field_samples. Needs no open store.
/// `shape` and `checksum` are those of the field chunk; its block_cells are read. `samples`: all
/// samples of the store's chunk, as isosplat_core_decode_chunk returns them. Result 0: a
/// PackedField for each.
IsosplatStatus isosplat_core_decode_field(IsosplatCore* core, const void* data, uint32_t bytes,
                                          const IsosplatChunkShape* shape, uint32_t checksum,
                                          const void* samples, uint32_t count, uint32_t value_bits);

/// Decodes a chunk of the open store to samples at the centres of its cells. Results, with one
/// entry per cell: world positions (3 floats), values (float), gradients in values per world unit
/// (3 floats), intervals as lowest and highest value (2 floats).
IsosplatStatus isosplat_core_decode_samples(IsosplatCore* core, const void* data, uint32_t bytes,
                                            const IsosplatChunkShape* shape);

/// Projects the active samples of a chunk onto an isosurface. Each yields one point, inside of its
/// cell. `exact` 0: one Newton step, no longer than the displacement threshold. 1: along the
/// gradient to the trilinear surface in the cell, or one Newton step if the ray misses the surface.
/// Results, with one entry per point: world positions (3 floats), unit normals in the direction of
/// the negative gradient (3 floats).
IsosplatStatus isosplat_core_project(IsosplatCore* core, const void* data, uint32_t bytes,
                                     const IsosplatChunkShape* shape, float quantized_isovalue,
                                     uint32_t exact);

/// Projects packed samples, as isosplat_core_decode_packed returns them, in the same way. Skips
/// samples outside of `regions` (ISOSPLAT_REGION_WORDS words; null: all regions). The error of the
/// points is that of the packed corners (PackedSample).
IsosplatStatus isosplat_core_project_packed(IsosplatCore* core, const void* samples, uint32_t count,
                                            const uint32_t* regions, const IsosplatBlock* block,
                                            float quantized_isovalue, uint32_t exact);

/// Selects the chunks and pages that a camera view needs: Selector::select. Results:
/// IsosplatSelectionHeader; IsosplatChunk for each chunk to load; pages to load (uint32_t);
/// IsosplatDrawnChunk for each chunk to draw; handles to test (uint32_t); handles to keep
/// (uint32_t).
IsosplatStatus isosplat_core_select(IsosplatCore* core, const IsosplatSelectionView* view,
                                    const float* quantized_isovalues, uint32_t isovalue_count);

/// Sets the answer of an occlusion query for the last selected view: Selector::set_visibility.
IsosplatStatus isosplat_core_set_visibility(IsosplatCore* core, const IsosplatVisibility* answer,
                                            uint32_t count);

/// Sets whether a chunk is resident, so that it may be drawn.
IsosplatStatus isosplat_core_set_resident(IsosplatCore* core, uint32_t handle, uint32_t resident);

#ifdef __cplusplus
}
#endif
