#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "shared/posix_file/posix_file.h"

namespace isosplat {

/// Storage for the slices of a coarse level until the level is encoded. Slices have equal size, and
/// are written and then read in ascending order. They are in memory, or in a temporary file without
/// a name, which the system removes even if the program crashes.
class SliceStore {
 public:
  /// In memory if `in_memory`, else in `folder`. Errors: io_error.
  static Result<SliceStore> create(size_t slice_bytes, int32_t slices, bool in_memory,
                                   const std::filesystem::path& folder);

  /// A buffer for the slices [first, first + count); valid until commit().
  std::byte* prepare(int32_t first, int32_t count);

  /// Stores the slices in the buffer of the last prepare(). Errors: io_error.
  Result<void> commit();

  /// Slices [first, first + count); valid until the next call. Errors: io_error.
  Result<const std::byte*> load(int32_t first, int32_t count);

 private:
  SliceStore() = default;
  size_t slice_bytes_ = 0;
  std::vector<std::byte> memory_;  // all slices, or the buffer of the last prepare() or load()
  PosixFile file_;
  int32_t prepared_first_ = 0, prepared_count_ = 0;
};

}  // namespace isosplat
