#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens an array of NumPy. Errors: those of open_volume.
Result<OpenVolume> open_npy(const std::filesystem::path& path, const ImportOptions& options);

/// Opens an array whose bytes are `bytes`; `is_plain`: their size is exact. Errors: as above.
Result<OpenVolume> open_npy_array(const std::filesystem::path& path,
                                  std::unique_ptr<ByteReader> bytes, bool is_plain,
                                  const ImportOptions& options);

/// The sizes of an array along its axes. Errors: as above.
Result<std::vector<int64_t>> npy_shape(const std::filesystem::path& path, ByteReader& bytes);

}  // namespace isosplat::import
