#include "shared/core/preprocess/label_field.h"

#include <algorithm>
#include <array>

namespace isosplat {
namespace {

constexpr int kRadius = 2;
constexpr int kWidth = 2 * kRadius + 1;
constexpr int kVoxels = kWidth * kWidth * kWidth;
constexpr std::array<int, kWidth> kKernel = {-1, 2, 6, 2, -1};
constexpr int kKernelSum = 8 * 8 * 8;

/// The distance from the isovalue that a voxel keeps at least, of 127.
constexpr int kLeastDistance = 13;

constexpr std::int32_t kOutsideVolume = -1;

using Neighbourhood = std::array<std::int32_t, kVoxels>;

std::int32_t label_at(const LabelVolume& volume, int x, int y, int z) {
  const int size_x = static_cast<int>(volume.size.x);
  const int size_y = static_cast<int>(volume.size.y);
  const int size_z = static_cast<int>(volume.size.z);
  if (x < 0 || y < 0 || z < 0 || x >= size_x || y >= size_y || z >= size_z) return kOutsideVolume;
  const std::size_t row =
      static_cast<std::size_t>(z) * static_cast<std::size_t>(size_y) + static_cast<std::size_t>(y);
  return volume.labels[row * static_cast<std::size_t>(size_x) + static_cast<std::size_t>(x)];
}

void gather(const LabelVolume& volume, int x, int y, int z, Neighbourhood& around) {
  std::size_t i = 0;
  for (int dz = -kRadius; dz <= kRadius; ++dz)
    for (int dy = -kRadius; dy <= kRadius; ++dy)
      for (int dx = -kRadius; dx <= kRadius; ++dx)
        around[i++] = label_at(volume, x + dx, y + dy, z + dz);
}

/// The weights of the label and of each other label around a voxel.
struct Weights {
  int own = 0;
  int largest_other = 0;
};

Weights find_weights(const Neighbourhood& around, std::int32_t label) {
  std::array<std::int32_t, kVoxels> others{};
  std::array<int, kVoxels> sums{};
  std::size_t count = 0;
  Weights weights;
  std::size_t i = 0;
  for (const int wz : kKernel)
    for (const int wy : kKernel)
      for (const int wx : kKernel) {
        const std::int32_t here = around[i++];
        const int weight = wx * wy * wz;
        if (here == label) {
          weights.own += weight;
          continue;
        }
        std::size_t slot = 0;
        while (slot < count && others[slot] != here) ++slot;
        if (slot == count) {
          others[slot] = here;
          sums[slot] = 0;
          ++count;
        }
        sums[slot] += weight;
      }
  for (std::size_t slot = 0; slot < count; ++slot)
    weights.largest_other = slot == 0 ? sums[0] : std::max(weights.largest_other, sums[slot]);
  return weights;
}

std::uint8_t field_value(const Neighbourhood& around, std::int32_t label) {
  const bool inside = around[kVoxels / 2] == label;
  const Weights weights = find_weights(around, label);
  // Division rounds towards 0, so that two labels' values have the same distance from the isovalue.
  const int distance = kLabelFieldIsovalue * (weights.own - weights.largest_other) / kKernelSum;
  const int limited = inside ? std::clamp(distance, kLeastDistance, int{kLabelFieldIsovalue})
                             : std::clamp(distance, -int{kLabelFieldIsovalue}, -kLeastDistance);
  return static_cast<std::uint8_t>(kLabelFieldIsovalue + limited);
}

}  // namespace

std::vector<std::uint8_t> label_field(const LabelVolume& volume, std::uint16_t label,
                                      const LabelBox& box) {
  std::vector<std::uint8_t> field;
  field.reserve(static_cast<std::size_t>(box.size.x) * static_cast<std::size_t>(box.size.y) *
                static_cast<std::size_t>(box.size.z));
  Neighbourhood around{};
  for (int z = 0; z < static_cast<int>(box.size.z); ++z)
    for (int y = 0; y < static_cast<int>(box.size.y); ++y)
      for (int x = 0; x < static_cast<int>(box.size.x); ++x) {
        gather(volume, static_cast<int>(box.first.x) + x, static_cast<int>(box.first.y) + y,
               static_cast<int>(box.first.z) + z, around);
        const bool holds_label =
            std::find(around.begin(), around.end(), std::int32_t{label}) != around.end();
        field.push_back(holds_label ? field_value(around, label) : std::uint8_t{0});
      }
  return field;
}

}  // namespace isosplat
