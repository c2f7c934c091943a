#pragma once

#include <memory>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/preprocess/layer.h"

namespace isosplat {

/// Makes a buffer at least as large as `bytes`. A larger buffer loses its content, so that there
/// are never two of them.
inline void make_room(std::vector<std::byte>& buffer, size_t bytes) {
  if (buffer.size() >= bytes) return;
  std::vector<std::byte>().swap(buffer);  // an assignment of {} would keep the memory
  buffer.resize(bytes);
}

/// Items of a level (voxels or cell intervals) in memory.
template <class Byte>
struct HeldBox {
  Byte* items = nullptr;
  LevelBox box = {};  ///< of the items: what was asked for, or all of its slices
};

/// Storage for the voxels or the cell intervals of a coarse level until the level is encoded. Boxes
/// reach over all of x. They are written in ascending order, each item once, and then read.
class SliceStore {
 public:
  virtual ~SliceStore() = default;

  /// A buffer for the items of a box; valid until commit().
  virtual HeldBox<std::byte> prepare(const LevelBox& box) = 0;

  /// Stores the box of the last prepare(). Errors: io_error.
  virtual Result<void> commit() = 0;

  /// The items of a box; valid until the next call. Errors: io_error.
  virtual Result<HeldBox<const std::byte>> load(const LevelBox& box) = 0;
};

/// A whole level in memory.
class MemorySlices : public SliceStore {
 public:
  MemorySlices(size_t item_bytes, const LevelBox& level)
      : item_bytes_(item_bytes), level_(level), memory_(item_bytes * level.count()) {}

  HeldBox<std::byte> prepare(const LevelBox& box) override {
    const LevelBox slices{{0, 0, box.first.z}, {level_.size.x, level_.size.y, box.size.z}};
    return {memory_.data() + item_bytes_ * level_.at(slices.first), slices};
  }
  Result<void> commit() override { return {}; }
  Result<HeldBox<const std::byte>> load(const LevelBox& box) override {
    const auto held = prepare(box);
    return HeldBox<const std::byte>{held.items, held.box};
  }

 private:
  const size_t item_bytes_;
  const LevelBox level_;
  std::vector<std::byte> memory_;
};

/// Storage outside of memory for levels that do not fit.
class SliceStorage {
 public:
  virtual ~SliceStorage() = default;
  /// level: all items of the level. Errors: io_error.
  virtual Result<std::unique_ptr<SliceStore>> create(size_t item_bytes, const LevelBox& level) = 0;
};

}  // namespace isosplat
