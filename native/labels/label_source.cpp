#include "native/labels/label_source.h"

#include <algorithm>
#include <array>

namespace isosplat {
namespace {

/// The voxels of a box along an axis from the first to the last voxel of a label: with
/// kLabelFieldReach more on each side, and up to three more, so that the cells of level 2 fill the
/// box. Else thin structures near the last voxel could be cut open at coarse levels, where they are
/// thicker.
int32_t box_voxels(int32_t low, int32_t high) {
  const int32_t cells = high - low + 2 * kLabelFieldReach;
  return (cells + 3) / 4 * 4 + 1;
}

LabelBox box_of(const FoundLabel& label) {
  constexpr int32_t kReach = kLabelFieldReach;
  return {{label.low.x - kReach, label.low.y - kReach, label.low.z - kReach},
          {box_voxels(label.low.x, label.high.x), box_voxels(label.low.y, label.high.y),
           box_voxels(label.low.z, label.high.z)}};
}

}  // namespace

VolumeGrid label_grid(const VolumeGrid& grid, const FoundLabel& label) {
  const LabelBox box = box_of(label);
  VolumeGrid cropped = grid;
  cropped.voxels = box.size;
  cropped.origin = grid.world({static_cast<double>(box.first.x), static_cast<double>(box.first.y),
                               static_cast<double>(box.first.z)});
  return cropped;
}

LabelSource::LabelSource(const LabelVolume& volume, const VolumeHeader& labels,
                         const FoundLabel& label, LabelSurface surface, std::string name)
    : volume_(volume), label_(label.index), box_(box_of(label)) {
  header_.grid = label_grid(labels.grid, label);
  header_.frame_of_reference = labels.frame_of_reference;
  header_.type = VoxelType::u8;
  header_.format = "label";
  header_.name = std::move(name);
  if (surface == LabelSurface::smooth) {
    field_ = std::make_unique<LabelField>(volume_, label_, box_);
  }
}

Result<void> LabelSource::read_slices(int32_t first, int32_t count, std::span<std::byte> out) {
  auto* to = reinterpret_cast<uint8_t*>(out.data());
  if (field_) {
    field_->compute(first, count, {to, out.size()});
    return {};
  }
  std::fill_n(to, out.size(), uint8_t{0});
  const Index3 n = volume_.size;
  for (int32_t z = box_.first.z + first; z < box_.first.z + first + count; ++z) {
    for (int32_t y = box_.first.y; y < box_.first.y + box_.size.y; ++y, to += box_.size.x) {
      if (y < 0 || z < 0 || y >= n.y || z >= n.z) continue;
      const uint16_t* const row = volume_.row(y, z);
      const int32_t begin = std::max(box_.first.x, 0);
      const int32_t end = std::min(box_.first.x + box_.size.x, n.x);
      for (int32_t x = begin; x < end; ++x) {
        if (row[x] == label_) to[x - box_.first.x] = kLabelFieldInside;
      }
    }
  }
  return {};
}

uint64_t LabelSource::resident_bytes() const {
  return field_ ? field_->memory_bytes() : 0;
}

std::shared_ptr<const VoxelScan> LabelSource::all_values() {
  static constexpr std::array<std::byte, 3> kValues{std::byte{0}, std::byte{1},
                                                    std::byte{kLabelFieldInside}};
  auto scan = std::make_shared<VoxelScan>(VoxelType::u8);
  scan->add(kValues);
  return scan;
}

}  // namespace isosplat
