#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"
#include "shared/import/codecs/packing.h"

namespace isosplat::import {

/// The beginning of a file, up to 4096 bytes, by which its format is recognized. It is read once,
/// and passed to all functions that need it.
struct FileHead {
  std::filesystem::path path;
  std::string stored;               ///< as it is in the file
  Packing packing = Packing::none;  ///< how the file is compressed
  std::optional<std::string>
      inside;  ///< the decompressed beginning of gzip data, if it can be decompressed

  bool is_gzip() const { return packing == Packing::gzip; }

  /// The beginning, decompressed if the file has gzip data.
  std::string_view bytes() const { return inside ? *inside : stored; }
};

/// Reads the beginning of a file. Errors: io_error; malformed_volume for an empty file.
Result<FileHead> read_head(const std::filesystem::path& path);

}  // namespace isosplat::import
