#include "native/build/isovalue_guess.h"

#include <algorithm>
#include <cmath>

#include "native/build/statistics.h"

namespace isosplat {

// Isovalues are likely anywhere in the range of a few slices, but less so where voxels crowd. There
// lie air and the insides of things, whose noise nobody wants to see, and whose cells would be cut
// into many slabs otherwise; and somewhat less so where there are hardly any. Against an even
// distribution: bunny 4.83 for 5.11 MB at 1000.5 and 0.532 for 0.525 × raw, engine 402 for 411 KB
// at 60.5 and 0.637 for 0.646 × raw.
Result<std::vector<double>> guess_isovalues(VolumeSource& source, const ValueCodes& value_codes) {
  constexpr int32_t kSlices = 24;
  constexpr uint32_t kBins = 256;
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const ValueMapping& mapping = value_codes.mapping();
  const size_t voxels = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  std::vector<std::byte> raw(voxels * voxel_bytes(header.type)), codes(voxels * mapping.bits / 8);
  VolumeStatistics sample;
  const int32_t count = std::min(kSlices, n.z);
  for (int32_t i = 0; i < count; ++i) {
    const auto z = static_cast<int32_t>((2 * int64_t{i} + 1) * n.z / (2 * count));
    if (auto read = source.read_slices(z, 1, raw); !read) return tl::unexpected(read.error());
    value_codes.encode(raw, codes.data());
    sample.add_codes(codes.data(), voxels, mapping.bits, mapping.has_missing);
  }
  const CellInterval range = sample.range();
  const CodeBins bins = CodeBins::over(range, kBins);
  const std::vector<uint64_t> histogram = sample.histogram(bins);
  const double mean = static_cast<double>(voxels) * count / bins.count;
  std::vector<double> distribution(65537);
  double sum = 0;
  for (uint32_t code = 0; code <= 65536; ++code) {
    distribution[code] = sum;
    if (code < range.min || code > range.max) continue;
    const double crowd = static_cast<double>(histogram[(code - bins.first) / bins.width]) / mean;
    sum += std::pow(crowd + 0.01, 0.25) / std::pow(1 + crowd, 1.25);
  }
  for (double& share : distribution) share /= sum;
  return distribution;
}

}  // namespace isosplat
