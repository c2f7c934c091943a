#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "native/labels/label_rows.h"
#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// A label of a volume.
struct FoundLabel {
  int64_t value = 0;
  uint16_t index = 0;  ///< in the LabelRows, ≥ 1
  uint64_t voxels = 0;
  Index3 low, high;  ///< its bounding box, both included
};

struct LabelScanOptions {
  std::optional<int64_t> background = 0;  ///< not a label; no value: all values are labels
  std::optional<int64_t> only;            ///< if set, all other values are no labels
  size_t max_labels = 4096;               ///< at most kMaxLabel
  std::function<void(double)> progress;   ///< receives the part that is done, 0 to 1
};

/// Reads a volume of labels into `rows`, which have its size: 0 where there is no label, else the
/// label's index. Returns its labels, by value. All values other than the background are labels,
/// also negative ones; voxels without a value (NaN) have none. Reads the volume once, some slices
/// at a time. Errors: those of the source; malformed_volume for values that are not integers or
/// beyond ±2^53, and for too many labels.
Result<std::vector<FoundLabel>> scan_labels(VolumeSource& source, LabelRows& rows,
                                            const LabelScanOptions& options);

}  // namespace isosplat
