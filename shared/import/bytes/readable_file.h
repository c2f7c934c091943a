#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "shared/core/base/status.h"
#include "shared/import/bytes/input_files.h"

namespace isosplat::import {

/// An open file, and its size when it was opened.
struct ReadableFile {
  /// Errors: those of size_of_file, io_error.
  static Result<ReadableFile> open(const std::filesystem::path& path);

  /// The error `truncated`. what: which bytes end early, such as "after decompression".
  tl::unexpected<Error> ends_early(uint64_t needed, uint64_t found, const char* what) const;

  std::filesystem::path path;
  uint64_t size = 0;
  std::unique_ptr<InputFile> input;
};

}  // namespace isosplat::import
