#pragma once

#include "native/import/volume_source.h"
#include "shared/preprocess/quantization.h"
#include "shared/preprocess/volume_sample.h"

namespace isosplat {

/// Reads 24 slices evenly spread, and up to 60 others, front to back; at most
/// 192 columns. Errors: those of the source.
Result<VolumeSample> sample_volume(VolumeSource& source, const Quantization& quantization,
                                   unsigned threads);

}  // namespace isosplat
