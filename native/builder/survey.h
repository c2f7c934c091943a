#pragma once

#include "shared/core/grid/volume_source.h"
#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// Values, statistics and quantization of a volume, as a build would compute them.
struct VolumeSurvey {
  double min = 0, max = 0;  ///< of the values; 0 if all voxels are missing
  uint64_t missing = 0;     ///< voxels without a value
  ValueMapping mapping;
  VolumeStatistics statistics;  ///< of quantized values, and of the cells of level 0
};

/// Reads the volume twice. The second pass reads a layer of blocks at a time, or fewer slices if
/// the quantized values of a layer exceed `layer_bytes`. Errors: those of the source.
Result<VolumeSurvey> survey_volume(VolumeSource& source, size_t layer_bytes = size_t{256} << 20);

}  // namespace isosplat
