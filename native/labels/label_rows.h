#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "shared/core/base/status.h"
#include "shared/core/preprocess/label_volume.h"

namespace isosplat {

/// The labels of a LabelVolume, all 0 at first: in memory, or in a temporary file that the system
/// maps into memory as needed, and removes even if the program crashes.
class LabelRows {
 public:
  /// `memory_bytes`: larger volumes are kept in a file in `folder`. Errors: io_error,
  /// out_of_memory.
  static Result<LabelRows> create(Index3 size, uint64_t memory_bytes,
                                  const std::filesystem::path& folder);

  LabelRows(LabelRows&& other) noexcept;
  LabelRows& operator=(LabelRows&&) = delete;
  ~LabelRows();

  /// The voxels of a row.
  uint16_t* row(int32_t y, int32_t z);
  LabelVolume volume() const;
  /// Of memory, without a temporary file.
  uint64_t memory_bytes() const { return is_file_ ? 0 : bytes_; }

 private:
  LabelRows() = default;

  Index3 size_;
  uint64_t bytes_ = 0;
  bool is_file_ = false;
  uint16_t* labels_ = nullptr;
};

}  // namespace isosplat
