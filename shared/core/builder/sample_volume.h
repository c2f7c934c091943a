#pragma once

#include "shared/core/builder/executor.h"
#include "shared/core/grid/volume_source.h"
#include "shared/core/preprocess/quantization.h"
#include "shared/core/preprocess/volume_sample.h"

namespace isosplat {

/// Reads a sample of the volume, front to back: 24 evenly spaced slices for the statistics of
/// values, and up to 60 slices with at most 192 columns of cells. Errors: those of the source.
Result<VolumeSample> sample_volume(VolumeSource& source, const Quantization& quantization,
                                   Executor& executor);

}  // namespace isosplat
