#include "shared/core/sampling/sample_neighbours.h"

#include <algorithm>
#include <array>
#include <vector>

namespace isosplat {
namespace {

constexpr uint32_t kCellBits = (1u << 18) - 1;  // x, y and z of the cell, of six bits each
constexpr uint32_t kNeighbourMask = 0xfu << 18 | 3u << 30;

CellInterval interval_of(const PackedSample& sample) {
  return {static_cast<QuantizedValue>(sample.word[1] & 0xffff),
          static_cast<QuantizedValue>(sample.word[1] >> 16)};
}

/// A structure in a cell: the part of the cell's interval that goes beyond its corners, on the side
/// where it goes further. It continues into another cell whose interval reaches at least half of
/// this part.
struct Structure {
  int corners_low = 65535, corners_high = 0;
  CellInterval interval;

  explicit Structure(const PackedSample& packed) {
    const UnpackedSample sample = unpack_sample(packed);
    interval = sample.interval;
    for (const float corner : sample.corners) {
      corners_low = std::min(corners_low, static_cast<int>(corner));
      corners_high = std::max(corners_high, static_cast<int>(corner));
    }
  }

  bool continues_in(CellInterval other) const {
    return interval.max - corners_high > corners_low - interval.min
               ? 2 * other.max >= interval.max + corners_high
               : 2 * other.min <= interval.min + corners_low;
  }
};

}  // namespace

void mark_neighbours(std::span<PackedSample> samples) {
  // For each cell of the block: the number of its sample plus one, or 0.
  std::vector<uint32_t> sample_at(kCellBits + 1);
  for (size_t i = 0; i < samples.size(); ++i) {
    sample_at[samples[i].word[0] & kCellBits] = static_cast<uint32_t>(i + 1);
  }
  for (PackedSample& sample : samples) {
    const uint32_t cell = sample.word[0] & kCellBits;
    const Structure structure(sample);
    NeighbourBits bits = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const uint32_t step = 1u << (6 * axis), coordinate = cell >> (6 * axis) & 63;
      const auto continues = [&](uint32_t neighbour) {
        const uint32_t found = sample_at[neighbour];
        return found != 0 && structure.continues_in(interval_of(samples[found - 1]));
      };
      const bool below = coordinate > 0 && continues(cell - step);
      const bool above = coordinate < 63 && continues(cell + step);
      bits |= uint32_t{coordinate > 0 ? below : above} << (2 * axis);
      bits |= uint32_t{coordinate < 63 ? above : below} << (2 * axis + 1);
    }
    sample.word[0] = (sample.word[0] & ~kNeighbourMask) | (bits & 15) << 18 | (bits >> 4) << 30;
  }
}

NeighbourBits neighbours_of(const PackedSample& sample) {
  return (sample.word[0] >> 18 & 15) | (sample.word[0] >> 30) << 4;
}

}  // namespace isosplat
