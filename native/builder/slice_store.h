#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "shared/posix_file/posix_file.h"

namespace isosplat {

/// A stack of slices of equal size that is written and then read in ascending order: a coarse level
/// while it waits for its turn. In memory where the builder can afford it, otherwise in a temporary
/// file without a name, which the system removes however the program ends.
class SliceStore {
 public:
  /// In memory if `in_memory`, else in `folder`. Errors: io_error.
  static Result<SliceStore> create(size_t slice_bytes, int32_t slices, bool in_memory,
                                   const std::filesystem::path& folder);

  /// Room to write slices [first, first + count) into; valid until commit().
  std::byte* prepare(int32_t first, int32_t count);

  /// Keeps what was written into the room given last. Errors: io_error.
  Result<void> commit();

  /// Slices [first, first + count); valid until the next call. Errors: io_error.
  Result<const std::byte*> load(int32_t first, int32_t count);

 private:
  SliceStore() = default;
  size_t slice_bytes_ = 0;
  std::vector<std::byte> memory_;  // all slices, or the room given last
  PosixFile file_;
  int32_t prepared_first_ = 0, prepared_count_ = 0;
};

}  // namespace isosplat
