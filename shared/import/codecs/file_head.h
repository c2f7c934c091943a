#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"
#include "shared/import/codecs/packing.h"

namespace isosplat::import {

/// The beginning of a file, up to 4096 bytes, which says what the file is. It is read once, and
/// handed to all who ask.
struct FileHead {
  std::filesystem::path path;
  std::string stored;                 ///< as it is in the file
  Packing packing = Packing::none;    ///< how the file is compressed
  std::optional<std::string> inside;  ///< of gzip data: their beginning, if it can be decompressed

  bool is_gzip() const { return packing == Packing::gzip; }

  /// The beginning, decompressed if it is that of gzip data.
  std::string_view bytes() const { return inside ? *inside : stored; }
};

/// Reads the beginning of a file. Errors: io_error; malformed_volume for an empty file.
Result<FileHead> read_head(const std::filesystem::path& path);

}  // namespace isosplat::import
