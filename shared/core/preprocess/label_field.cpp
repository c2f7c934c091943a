#include "shared/core/preprocess/label_field.h"

#include <algorithm>
#include <climits>
#include <cstring>

namespace isosplat {
namespace {

constexpr int kReach = kLabelFieldReach;
constexpr int kWidth = 2 * kReach + 1;
constexpr int kRows = kWidth * kWidth;
constexpr int kVoxels = kWidth * kRows;
constexpr std::array<int, kWidth> kKernel = {-1, 2, 6, 2, -1};
constexpr int kKernelSum = 8 * 8 * 8;

/// The distance from the isovalue that a voxel keeps at least, of kLabelFieldIsovalue.
constexpr int kLeastDistance = 10;

/// Vectors of labels and weights. A row of kWidth voxels is the first lanes; the others are
/// ignored.
using Lanes = int16_t __attribute__((vector_size(16)));
constexpr int kLanes = 8;

/// The kernel's weight of each voxel around the centre, and 0 in the other lanes.
constexpr auto kWeights = [] {
  std::array<std::array<int16_t, kLanes>, kRows> weights{};
  for (int row = 0; row < kRows; ++row) {
    for (int x = 0; x < kWidth; ++x) {
      weights[static_cast<size_t>(row)][static_cast<size_t>(x)] = static_cast<int16_t>(
          kKernel[static_cast<size_t>(row / kWidth)] * kKernel[static_cast<size_t>(row % kWidth)] *
          kKernel[static_cast<size_t>(x)]);
    }
  }
  return weights;
}();

/// The labels around a voxel: its rows, by y and then z.
using Around = std::array<Lanes, kRows>;

/// The rows around a row of voxels, from kReach voxels before it on.
using Rows = std::array<const uint16_t*, kRows>;

Lanes load(const void* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

Lanes splat(int value) {
  const auto lane = static_cast<int16_t>(value);
  return Lanes{lane, lane, lane, lane, lane, lane, lane, lane};
}

int sum(Lanes lanes) {
  return lanes[0] + lanes[1] + lanes[2] + lanes[3] + lanes[4];
}

struct Count {
  int weight = 0;  ///< of kKernelSum
  int voxels = 0;
};

Count count(const Around& around, int label) {
  const Lanes wanted = splat(label);
  Lanes weights = splat(0), voxels = weights;
  for (size_t row = 0; row < kRows; ++row) {
    const Lanes found = around[row] == wanted;
    weights += found & load(kWeights[row].data());
    voxels -= found;
  }
  return {sum(weights), sum(voxels)};
}

/// The voxels around one: those with its label, and the range of the others.
struct Others {
  Count own;
  int least = 0, most = 0;
};

/// Labels are at most kMaxLabel, so comparing them as signed numbers is right.
Others others_of(const Around& around, int label) {
  const Lanes own = splat(label), above = splat(INT16_MAX);
  Lanes weights = splat(0), voxels = weights, least = above, most = splat(-1);
  for (size_t row = 0; row < kRows; ++row) {
    const Lanes here = around[row];
    const Lanes is_own = here == own;
    weights += is_own & load(kWeights[row].data());
    voxels -= is_own;
    const Lanes low = here | (is_own & above), high = here | is_own;
    least = low < least ? low : least;
    most = high > most ? high : most;
  }
  Others found{{sum(weights), sum(voxels)}, least[0], most[0]};
  for (int i = 1; i < kWidth; ++i) {
    found.least = std::min<int>(found.least, least[i]);
    found.most = std::max<int>(found.most, most[i]);
  }
  return found;
}

/// The largest weight of another label, where there are several.
int largest_other(const Around& around, int label, const Others& others) {
  std::array<int, kVoxels> known{label};
  size_t labels = 1;
  int voxels = others.own.voxels, largest = INT_MIN;
  const auto add = [&](int other) {
    const Count found = count(around, other);
    known[labels++] = other;
    voxels += found.voxels;
    largest = std::max(largest, found.weight);
  };
  add(others.least);
  add(others.most);
  for (size_t row = 0; row < kRows && voxels < kVoxels; ++row) {
    for (int i = 0; i < kWidth && voxels < kVoxels; ++i) {
      const int here = around[row][i];
      const auto end = known.begin() + static_cast<ptrdiff_t>(labels);
      if (std::find(known.begin(), end, here) == end) add(here);
    }
  }
  return largest;
}

uint8_t field_value(const Rows& rows, int x, int label) {
  Around around;
  for (size_t row = 0; row < kRows; ++row) around[row] = load(rows[row] + x);
  const Others others = others_of(around, label);
  const int other = others.least == others.most ? kKernelSum - others.own.weight
                                                : largest_other(around, label, others);
  // Division rounds towards 0, so that two labels' values have the same distance from the isovalue.
  const int distance = kLabelFieldIsovalue * (others.own.weight - other) / kKernelSum;
  const bool inside = around[kRows / 2][kReach] == label;
  const int limited = inside ? std::clamp(distance, kLeastDistance, int{kLabelFieldIsovalue})
                             : std::clamp(distance, -int{kLabelFieldIsovalue}, -kLeastDistance);
  return static_cast<uint8_t>(kLabelFieldIsovalue + limited);
}

/// For each voxel, how many of the kWidth voxels around it have the label. Returns whether any has.
/// `row`: from kReach voxels before the first on.
bool count_in_row(const uint16_t* row, uint16_t label, uint8_t* counts, int32_t voxels) {
  uint8_t any = 0;
  for (int32_t x = 0; x < voxels; ++x) {
    int found = 0;
    for (int i = 0; i < kWidth; ++i) found += row[x + i] == label ? 1 : 0;
    counts[x] = static_cast<uint8_t>(found);
    any = static_cast<uint8_t>(any | counts[x]);
  }
  return any != 0;
}

void add_row(const uint8_t* from, uint8_t* to, int32_t voxels) {
  for (int32_t x = 0; x < voxels; ++x) to[x] = static_cast<uint8_t>(to[x] + from[x]);
}

}  // namespace

LabelField::LabelField(const LabelVolume& volume, uint16_t label, const LabelBox& box)
    : volume_(volume), label_(label), box_(box), empty_row_(volume.row_size(volume.size.x)) {
  const auto rows = static_cast<size_t>(box.size.y), voxels = static_cast<size_t>(box.size.x);
  rows_with_label_.resize(rows + 2 * kReach);
  row_counts_.resize(rows_with_label_.size() * voxels);
  for (SliceCounts& slice : slices_) {
    slice.counts.resize(rows * voxels);
    slice.has_label.resize(rows);
  }
}

/// The first voxel of the row that may be read for the box: kReach before the box.
const uint16_t* LabelField::row(int32_t y, int32_t z) const {
  const int32_t first = box_.first.x - kReach + LabelVolume::kBefore;
  y += box_.first.y;
  z += box_.first.z;
  if (y < 0 || z < 0 || y >= volume_.size.y || z >= volume_.size.z) return &empty_row_[0] + first;
  const size_t number =
      static_cast<size_t>(z) * static_cast<size_t>(volume_.size.y) + static_cast<size_t>(y);
  return volume_.rows.data() + number * volume_.row_size(volume_.size.x) + first;
}

void LabelField::count_slice(int32_t z, SliceCounts& slice) {
  const int32_t voxels = box_.size.x;
  const auto counts_of = [&](int32_t y) {
    return row_counts_.data() + static_cast<ptrdiff_t>(y + kReach) * voxels;
  };
  for (int32_t y = -kReach; y < box_.size.y + kReach; ++y) {
    rows_with_label_[static_cast<size_t>(y + kReach)] =
        count_in_row(row(y, z), label_, counts_of(y), voxels) ? 1 : 0;
  }
  for (int32_t y = 0; y < box_.size.y; ++y) {
    const uint8_t* const has_label = rows_with_label_.data() + y;
    const bool any = std::any_of(has_label, has_label + kWidth, [](uint8_t has) { return has; });
    slice.has_label[static_cast<size_t>(y)] = any ? 1 : 0;
    if (!any) continue;
    uint8_t* const sums = slice.counts.data() + static_cast<ptrdiff_t>(y) * voxels;
    std::memset(sums, 0, static_cast<size_t>(voxels));
    for (int32_t dy = -kReach; dy <= kReach; ++dy) {
      if (has_label[dy + kReach]) add_row(counts_of(y + dy), sums, voxels);
    }
  }
}

void LabelField::compute_row(int32_t y, int32_t z, const uint8_t* counts, uint8_t* out) const {
  Rows rows;
  for (int i = 0; i < kRows; ++i) {
    rows[static_cast<size_t>(i)] = row(y + i % kWidth - kReach, z + i / kWidth - kReach);
  }
  for (int32_t x = 0; x < box_.size.x; ++x) {
    if (counts[x] == 0 || counts[x] == kVoxels) {
      out[x] = counts[x] == 0 ? 0 : kLabelFieldInside;
    } else {
      out[x] = field_value(rows, x, label_);
    }
  }
}

void LabelField::compute(int32_t first, int32_t count, std::span<uint8_t> out) {
  const int32_t voxels = box_.size.x;
  const auto slice_of = [&](int32_t z) -> SliceCounts& {
    return slices_[static_cast<size_t>((z + kWidth) % kWidth)];
  };
  for (int32_t z = first - kReach; z < first + kReach; ++z) count_slice(z, slice_of(z));
  std::vector<uint8_t> counts(static_cast<size_t>(voxels));
  uint8_t* to = out.data();
  for (int32_t z = first; z < first + count; ++z) {
    count_slice(z + kReach, slice_of(z + kReach));
    for (int32_t y = 0; y < box_.size.y; ++y, to += voxels) {
      std::memset(counts.data(), 0, counts.size());
      bool any = false;
      for (const SliceCounts& slice : slices_) {
        if (!slice.has_label[static_cast<size_t>(y)]) continue;
        any = true;
        add_row(slice.counts.data() + static_cast<ptrdiff_t>(y) * voxels, counts.data(), voxels);
      }
      if (any) {
        compute_row(y, z, counts.data(), to);
      } else {
        std::memset(to, 0, static_cast<size_t>(voxels));
      }
    }
  }
}

}  // namespace isosplat
