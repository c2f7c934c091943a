#pragma once

#include <stdint.h>

#include "shared/wasm/core_api.h"

/// Area and volume of isosurfaces for JavaScript: exported by the module `isosplat-measure`, which
/// is loaded when they are first asked for. web/measure/surface_extent.ts calls it. A module
/// instance sums up one isosurface at a time.
#ifdef __cplusplus
extern "C" {
#endif

/// Begins the sums of a volume's isosurface. lowest_quantized: the volume's smallest value.
void isosplat_measure_begin(const IsosplatVolume* volume, float quantized_isovalue,
                            uint32_t lowest_quantized);

/// Adds a chunk of level 0 that has the isovalue in its band. Errors: checksum_mismatch, and those
/// of ChunkDecoder.
IsosplatStatus isosplat_measure_add(const void* data, uint32_t bytes,
                                    const IsosplatChunkShape* shape, uint32_t checksum);

/// result: SurfaceExtent's area, volume above, and volume of the grid.
void isosplat_measure_result(double* result);

#ifdef __cplusplus
}
#endif
