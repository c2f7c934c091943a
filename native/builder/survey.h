#pragma once

#include "native/import/volume_source.h"
#include "shared/preprocess/statistics.h"

namespace isosplat {

/// What a build would learn of a volume, without building.
struct VolumeSurvey {
  double min = 0, max = 0;  ///< of the values; 0 and 0 where there is none
  uint64_t missing = 0;     ///< voxels without a value
  ValueMapping mapping;
  VolumeStatistics statistics;  ///< of quantized values, and of the cells of level 0
};

/// Reads the volume twice, a layer of blocks at a time, or a thinner one where its quantized values
/// would take more than `layer_bytes`. Errors: those of the source.
Result<VolumeSurvey> survey_volume(VolumeSource& source, size_t layer_bytes = size_t{256} << 20);

}  // namespace isosplat
