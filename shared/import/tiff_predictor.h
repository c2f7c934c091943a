#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/import/stored_voxels.h"

namespace isosplat {

/// Whether a predictor (tag 317) can be undone for voxels of this type: 1 (none), 2 (each voxel is
/// stored as the difference from its left neighbour; TIFF 6.0, section 14), 3 (the same for the
/// bytes of floating-point numbers, sorted by significance; Adobe Photoshop TIFF Technical Note 3).
bool knows_predictor(uint64_t predictor, VoxelType type);

/// Makes native-endian voxels of rows as they were stored.
void undo_predictor(uint64_t predictor, const StoredVoxels& voxels, size_t row_bytes,
                    std::span<std::byte> rows);

}  // namespace isosplat
