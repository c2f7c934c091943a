#include "native/headless/field_counts.h"

#include <algorithm>
#include <numeric>

namespace isosplat {

FieldCounts::FieldCounts(const ValueMapping& field, std::span<const float> isovalues)
    : field_(field), isovalues_(isovalues.begin(), isovalues.end()), counts_(65536) {}

void FieldCounts::add(std::span<const PackedSample> samples, std::span<const PackedField> values) {
  for (size_t i = 0; i < samples.size(); ++i) {
    const uint32_t min = samples[i].word[1] & 0xffff, max = samples[i].word[1] >> 16;
    const auto is_active = [&](float isovalue) {
      return float(min) <= isovalue && isovalue < float(max);
    };
    if (std::none_of(isovalues_.begin(), isovalues_.end(), is_active)) continue;
    uint32_t sum = 0;
    bool is_missing = false;
    for (const uint32_t word : values[i].word) {
      sum += (word & 0xffff) + (word >> 16);
      is_missing |= (word & 0xffff) == kMissingVoxel || word >> 16 == kMissingVoxel;
    }
    if (!(is_missing && field_.has_missing)) ++counts_[(sum + 4) / 8];
  }
}

std::optional<std::array<double, 2>> FieldCounts::percentiles() const {
  const uint64_t all = std::accumulate(counts_.begin(), counts_.end(), uint64_t{0});
  if (all == 0) return std::nullopt;
  // The smallest value that more than this number of cells do not exceed.
  const auto value_beyond = [&](uint64_t below) {
    uint64_t sum = 0;
    size_t value = 0;
    while ((sum += counts_[value]) <= below) ++value;
    return field_.value(double(value));
  };
  return std::array{value_beyond(all / 100), value_beyond(all - 1 - all / 100)};
}

}  // namespace isosplat
