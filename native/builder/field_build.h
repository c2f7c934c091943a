#pragma once

#include <span>
#include <string>

#include "native/builder/builder.h"
#include "shared/core/categories/categories.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// Whether a volume can be a field of a store with this grid: it has the same number of voxels.
/// Errors: invalid_argument.
Result<void> check_field_grid(const std::string& name, Index3 store, Index3 field);

/// Writes the field of a store: for each of its chunks, the values of another volume at the corners
/// of the cells, at every level. Coarse values are the averages of coarsen_block(). If values are
/// labels, `categories` are all of them, and coarse values are those of PickedLevels. Reads the
/// cells of the store's chunks. Of the options it takes max_error, threads, memory_bytes,
/// temporary_folder, progress, notes and source_file. The bytes do not depend on the threads.
/// Errors: those of build_store, StoreFile, check_field and check_field_grid.
Result<FieldInfo> build_field(const StoreFile& store, const std::string& name, VolumeSource& source,
                              ByteSink& sink, const BuildOptions& options,
                              std::span<const Category> categories = {});

}  // namespace isosplat
