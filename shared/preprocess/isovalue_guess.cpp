#include "shared/preprocess/isovalue_guess.h"

#include <cmath>

namespace isosplat {

// Isovalues are likely anywhere in the range of the sample, but less so where voxels crowd. There
// lie air and the insides of things, whose noise nobody wants to see, and whose cells would be cut
// into many bands otherwise; and somewhat less so where there are hardly any. Against an even
// distribution: bunny 4.83 for 5.11 MB at 1000.5 and 0.532 for 0.525 × raw, engine 402 for 411 KB
// at 60.5 and 0.637 for 0.646 × raw.
std::vector<double> guess_isovalues(const VolumeStatistics& sample, uint64_t voxels) {
  constexpr uint32_t kBins = 256;
  const CellInterval range = sample.range();
  const QuantizedBins bins = QuantizedBins::over(range, kBins);
  const std::vector<uint64_t> histogram = sample.histogram(bins);
  const double mean = static_cast<double>(voxels) / bins.count;
  std::vector<double> distribution(65537);
  double sum = 0;
  for (uint32_t quantized = 0; quantized <= 65536; ++quantized) {
    distribution[quantized] = sum;
    if (quantized < range.min || quantized > range.max) continue;
    const double crowd =
        static_cast<double>(histogram[(quantized - bins.first) / bins.width]) / mean;
    sum += std::pow(crowd + 0.01, 0.25) / std::pow(1 + crowd, 1.25);
  }
  for (double& share : distribution) share /= sum;
  return distribution;
}

}  // namespace isosplat
