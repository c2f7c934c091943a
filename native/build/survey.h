#pragma once

#include "native/build/statistics.h"
#include "native/build/value_codes.h"
#include "native/import/volume_source.h"

namespace isosplat {

/// What a build would learn of a volume, without building.
struct VolumeSurvey {
  ValueRange range;  ///< of the values, with the number of those missing
  ValueMapping mapping;
  VolumeStatistics statistics;  ///< of codes, and of the cells of level 0
};

/// Reads the volume twice, a layer of blocks at a time, or a thinner one where its codes would take
/// more than `layer_bytes`. Errors: those of the source.
Result<VolumeSurvey> survey_volume(VolumeSource& source, size_t layer_bytes = size_t{256} << 20);

}  // namespace isosplat
