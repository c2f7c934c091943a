#pragma once

#include <stdint.h>

#include "shared/bindings/wasm/core_api.h"

/// Triangles of isosurfaces for JavaScript: as files, or summed up to area and volume. Exported by
/// the module `isosplat-mesh`, which is loaded when it is first needed; web/mesh calls it. A module
/// instance works on one isosurface at a time: begin, add its chunks, and finish.
///
/// The rules are those of core_api.h. After a function has failed, begin again.
#ifdef __cplusplus
extern "C" {
#endif

/// The numbers of the result buffers.
enum {
  ISOSPLAT_MESH_BODY,  ///< bytes of the part: see MeshEncoder
  ISOSPLAT_MESH_TAIL,
  ISOSPLAT_MESH_HEADER,
  ISOSPLAT_MESH_NUMBERS  ///< doubles
};

/// The message of the last error, and the name of a status: UTF-8, null-terminated.
const char* isosplat_mesh_error(void);
const char* isosplat_mesh_status_name(IsosplatStatus status);

/// A result buffer, and its size in bytes.
const void* isosplat_mesh_result(uint32_t buffer);
uint32_t isosplat_mesh_result_bytes(uint32_t buffer);

/// Begins to compute the area and volume of an isosurface. lowest_quantized: the volume's smallest
/// value.
IsosplatStatus isosplat_mesh_begin_extent(const IsosplatVolume* volume, float quantized_isovalue,
                                          uint32_t lowest_quantized);

/// Begins a file. format: a MeshFormatId. comment: a line for the file's header.
IsosplatStatus isosplat_mesh_begin_file(const IsosplatVolume* volume, uint32_t level,
                                        float quantized_isovalue, uint32_t format,
                                        const char* comment, uint32_t comment_bytes);

/// Limits the file to a region (CellRegion::in_grid). Call it after begin_file. box: six numbers,
/// the low corner and the high one.
IsosplatStatus isosplat_mesh_set_region(const double* box);

/// Closes the surface of the file, within a box in voxels of level 0 (SolidRegion). Call it after
/// begin_file, instead of set_region. planes: four numbers each, a normal and an offset in the
/// world. The whole mesh is then in memory. Errors: those of SolidRegion.
IsosplatStatus isosplat_mesh_close(const double* box, const double* planes, uint32_t plane_count);

/// Adds a chunk of the level that has the isovalue in its band. The chunks of a file must be added
/// in ascending order by z, then y, then x. Errors: checksum_mismatch, and those of ChunkDecoder
/// and MeshAssembly.
IsosplatStatus isosplat_mesh_add(const void* data, uint32_t bytes, const IsosplatChunkShape* shape,
                                 uint32_t checksum);

/// How many parts of the file are complete and not encoded yet. Encode them before the next add.
uint32_t isosplat_mesh_parts_left(void);

/// Encodes the next complete part. Results: its body and its tail. Errors: those of MeshEncoder.
IsosplatStatus isosplat_mesh_encode_part(void);

/// No chunk follows: completes the last parts of a file. Errors: those of SolidRegion::close.
IsosplatStatus isosplat_mesh_finish(void);

/// Call it when all parts are encoded. Results: the header, and NUMBERS. These are, for a file:
/// vertices and triangles; for an extent: area, volume above, volume of the grid.
IsosplatStatus isosplat_mesh_summary(void);

#ifdef __cplusplus
}
#endif
