#pragma once

#include <cstdint>
#include <vector>

#include "native/import/volume_source.h"

namespace isosplat::cli {

/// What reading all voxels of a volume tells.
struct VolumeScan {
  double low = 0, high = 0;       ///< of the finite values
  uint64_t non_finite = 0;        ///< NaN and infinities
  std::vector<double> histogram;  ///< counts of 256 equal parts of [low, high]
};

/// Reads the volume twice, a few slices at a time. Errors: those of the source.
Result<VolumeScan> scan_volume(VolumeSource& source);

}  // namespace isosplat::cli
