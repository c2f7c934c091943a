#include "shared/core/preprocess/isovalue_guess.h"

#include "shared/core/base/portable_math.h"

namespace isosplat {

// Any isovalue in the range of the sample is possible. Values that very many voxels have are less
// likely. They belong to air and to the interior of materials: nobody wants to see their noise, and
// their cells would otherwise be cut into many bands. Values that hardly any voxel has are somewhat
// less likely, too. Compared with a uniform distribution: bunny 4.83 instead of 5.11 MB at isovalue
// 1000.5 and a store of 0.532 instead of 0.525 times the voxels; engine 402 instead of 411 KB at
// 60.5 and 0.637 instead of 0.646.
std::vector<double> guess_isovalues(const VolumeStatistics& sample, uint64_t voxels) {
  constexpr uint32_t kBins = 256;
  const CellInterval range = sample.range();
  const QuantizedBins bins = QuantizedBins::over(range, kBins);
  const std::vector<uint64_t> histogram = sample.histogram(bins);
  const double mean = static_cast<double>(voxels) / bins.count;
  std::vector<double> weights;  // of each quantized value of a bin
  for (const uint64_t count : histogram) {
    const double crowd = static_cast<double>(count) / mean;
    weights.push_back(portable::pow(crowd + 0.01, 0.25) / portable::pow(1 + crowd, 1.25));
  }
  std::vector<double> distribution(65537);
  double sum = 0;
  for (uint32_t quantized = 0; quantized <= 65536; ++quantized) {
    distribution[quantized] = sum;
    if (quantized < range.min || quantized > range.max) continue;
    sum += weights[(quantized - bins.first) / bins.width];
  }
  for (double& share : distribution) share /= sum;
  return distribution;
}

}  // namespace isosplat
