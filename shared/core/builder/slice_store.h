#pragma once

#include <memory>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat {

/// Storage for the slices of a coarse level until the level is encoded. Slices have equal size, and
/// are written and then read in ascending order.
class SliceStore {
 public:
  virtual ~SliceStore() = default;

  /// A buffer for the slices [first, first + count); valid until commit().
  virtual std::byte* prepare(int32_t first, int32_t count) = 0;

  /// Stores the slices in the buffer of the last prepare(). Errors: io_error.
  virtual Result<void> commit() = 0;

  /// Slices [first, first + count); valid until the next call. Errors: io_error.
  virtual Result<const std::byte*> load(int32_t first, int32_t count) = 0;
};

/// Slices in memory.
class MemorySlices : public SliceStore {
 public:
  MemorySlices(size_t slice_bytes, int32_t slices)
      : slice_bytes_(slice_bytes), memory_(slice_bytes * static_cast<size_t>(slices)) {}

  std::byte* prepare(int32_t first, int32_t) override { return at(first); }
  Result<void> commit() override { return {}; }
  Result<const std::byte*> load(int32_t first, int32_t) override { return at(first); }

 private:
  std::byte* at(int32_t slice) {
    return memory_.data() + slice_bytes_ * static_cast<size_t>(slice);
  }
  size_t slice_bytes_;
  std::vector<std::byte> memory_;
};

/// Storage outside of memory for levels that do not fit.
class SliceStorage {
 public:
  virtual ~SliceStorage() = default;
  /// Errors: io_error.
  virtual Result<std::unique_ptr<SliceStore>> create(size_t slice_bytes) = 0;
};

}  // namespace isosplat
