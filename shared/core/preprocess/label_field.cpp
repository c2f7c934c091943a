#include "shared/core/preprocess/label_field.h"

#include <algorithm>
#include <array>

#include "shared/core/preprocess/label_balance.h"
#include "shared/core/preprocess/label_distance.h"
#include "shared/core/preprocess/label_smoothing.h"

namespace isosplat {
namespace {

/// Voxels around the box that are computed too. At those beyond, the distances are extrapolated.
constexpr int32_t kAround = 3;

/// The largest tile along an axis, the voxels around a tile that influence it, and the largest part
/// of a box that becomes a tile.
constexpr int32_t kMaxTile = 224, kInfluence = 32, kMaxPart = kMaxTile - 2 * kInfluence;

/// Upper limit of the voxels of a band, if it has more than kMinBandSlices slices.
constexpr int64_t kMaxBandVoxels = int64_t{1} << 26;
constexpr int32_t kMinBandSlices = 32;

/// The distances for smooth_distances(). The first pass removes the stairs of the voxels. The
/// second pass, after the first shift, removes the ripples that remain because voxels stay on their
/// side.
constexpr std::array<int32_t, 3> kStairs = {2, 4, 6}, kRipples = {2, 1, 1};

int32_t parts_of(int32_t voxels) {
  return voxels + 2 * kAround <= kMaxTile ? 1 : (voxels + kMaxPart - 1) / kMaxPart;
}

int32_t part_begin(int32_t part, int32_t parts, int32_t voxels) {
  return static_cast<int32_t>(int64_t{part} * voxels / parts);
}

/// The first voxel of a tile and its end, along one axis of a box.
int32_t tile_begin(int32_t first) {
  return std::max(first - kInfluence, -kAround);
}
int32_t tile_end(int32_t end, int32_t voxels) {
  return std::min(end + kInfluence, voxels + kAround);
}

/// A distance in steps of the field: rounded to the nearest, but at least one step. The negative
/// distance gives the negative result.
constexpr int field_steps(int16_t distance) {
  const int positive = distance < 0 ? -distance : distance;
  const int steps = (positive * kLabelFieldSteps + kLabelVoxel / 2) / kLabelVoxel;
  const int limited = std::clamp<int>(steps, 1, kLabelFieldIsovalue);
  return distance < 0 ? -limited : limited;
}
static_assert(field_steps(kLabelLeast) == 1 && field_steps(-kLabelLeast) == -1);

}  // namespace

LabelField::LabelField(const LabelVolume& volume, uint16_t label, const LabelBox& box)
    : volume_(volume), label_(label), box_(box) {
  const auto most =
      std::max<int64_t>(kMaxBandVoxels / static_cast<int64_t>(slice_voxels()), kMinBandSlices);
  const int32_t parts = parts_of(box.size.z);
  band_slices_ = static_cast<int32_t>(std::min<int64_t>((box.size.z + parts - 1) / parts, most));
  bands_ = (box.size.z + band_slices_ - 1) / band_slices_;
}

size_t LabelField::slice_voxels() const {
  return static_cast<size_t>(box_.size.x) * static_cast<size_t>(box_.size.y);
}

uint64_t LabelField::memory_bytes() const {
  const auto along = [](int32_t voxels, int32_t parts) {
    const int32_t part = (voxels + parts - 1) / parts;
    return static_cast<uint64_t>(std::min(part + 2 * kInfluence, voxels + 2 * kAround));
  };
  const uint64_t tile = along(box_.size.x, parts_of(box_.size.x)) *
                        along(box_.size.y, parts_of(box_.size.y)) * along(box_.size.z, bands_);
  // A tile has two numbers of 16 bits a voxel. Rows and bricks take less than another byte.
  return 5 * tile + slice_voxels() * static_cast<uint64_t>(band_slices_);
}

void LabelField::compute_tile(Index3 first, Index3 end) {
  LabelTile tile;
  const Index3 begin{tile_begin(first.x), tile_begin(first.y), tile_begin(first.z)};
  tile.first = {box_.first.x + begin.x, box_.first.y + begin.y, box_.first.z + begin.z};
  tile.size = {tile_end(end.x, box_.size.x) - begin.x, tile_end(end.y, box_.size.y) - begin.y,
               tile_end(end.z, box_.size.z) - begin.z};
  compute_distances(volume_, label_, tile);
  smooth_distances(tile, kStairs);
  balance_volume(tile, 1);
  smooth_distances(tile, kRipples);
  balance_volume(tile, 3);
  for (int32_t z = first.z; z < end.z; ++z) {
    for (int32_t y = first.y; y < end.y; ++y) {
      const int16_t* const from =
          tile.values.data() + tile.row_begin(y - begin.y, z - begin.z) + (first.x - begin.x);
      uint8_t* const to = band_.data() + slice_voxels() * static_cast<size_t>(z - first_) +
                          static_cast<size_t>(y) * static_cast<size_t>(box_.size.x) + first.x;
      for (int32_t x = 0; x < end.x - first.x; ++x) {
        to[x] = static_cast<uint8_t>(kLabelFieldIsovalue + field_steps(from[x]));
      }
    }
  }
}

void LabelField::compute_band(int32_t number) {
  first_ = part_begin(number, bands_, box_.size.z);
  end_ = part_begin(number + 1, bands_, box_.size.z);
  band_.resize(slice_voxels() * static_cast<size_t>(end_ - first_));
  const int32_t across = parts_of(box_.size.x), down = parts_of(box_.size.y);
  for (int32_t j = 0; j < down; ++j) {
    for (int32_t i = 0; i < across; ++i) {
      compute_tile(
          {part_begin(i, across, box_.size.x), part_begin(j, down, box_.size.y), first_},
          {part_begin(i + 1, across, box_.size.x), part_begin(j + 1, down, box_.size.y), end_});
    }
  }
}

void LabelField::compute(int32_t first, int32_t count, std::span<uint8_t> out) {
  uint8_t* to = out.data();
  const int32_t end = first + count;
  while (first < end) {
    if (first < first_ || first >= end_) {
      int32_t number = 0;
      while (part_begin(number + 1, bands_, box_.size.z) <= first) ++number;
      compute_band(number);
    }
    const auto slices = static_cast<size_t>(std::min(end, end_) - first);
    const uint8_t* const from = band_.data() + slice_voxels() * static_cast<size_t>(first - first_);
    to = std::copy_n(from, slice_voxels() * slices, to);
    first += static_cast<int32_t>(slices);
  }
}

}  // namespace isosplat
