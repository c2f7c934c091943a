#pragma once

#include <filesystem>

#include "shared/core/builder/slice_store.h"

namespace isosplat {

/// Stores the slices of levels in temporary files without a name, which the system removes even if
/// the program crashes.
class FileSliceStorage : public SliceStorage {
 public:
  explicit FileSliceStorage(std::filesystem::path folder) : folder_(std::move(folder)) {}
  Result<std::unique_ptr<SliceStore>> create(size_t item_bytes, const LevelBox& level) override;

 private:
  std::filesystem::path folder_;
};

}  // namespace isosplat
