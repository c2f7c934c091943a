#include "native/builder/distance_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "native/builder/signed_distance.h"
#include "native/builder/slice_window.h"

namespace isosplat {
namespace {

/// Whether the axes are perpendicular: distances are then separable.
bool has_right_angles(const VolumeGrid& grid) {
  const Vec3d x = column(grid.direction, 0), y = column(grid.direction, 1),
              z = column(grid.direction, 2);
  return std::max({std::abs(dot(x, y)), std::abs(dot(y, z)), std::abs(dot(x, z))}) <= 1e-4;
}

uint64_t voxels_of(const VolumeGrid& grid) {
  return static_cast<uint64_t>(grid.voxels.x) * static_cast<uint64_t>(grid.voxels.y) *
         static_cast<uint64_t>(grid.voxels.z);
}

}  // namespace

Result<std::unique_ptr<DistanceSource>> DistanceSource::create(const std::string& name,
                                                               std::unique_ptr<VolumeSource> volume,
                                                               const VolumeGrid& grid,
                                                               std::vector<int64_t> labels,
                                                               uint64_t memory_bytes) {
  if (!has_right_angles(grid)) {
    return fail(Status::unsupported_format,
                fmt::format("field '{}': expected labels on a grid with right angles, found a "
                            "sheared one: resample them first",
                            name));
  }
  const uint64_t needed = voxels_of(grid) * sizeof(float);
  if (needed > memory_bytes) {
    return fail(Status::out_of_memory,
                fmt::format("field '{}': expected a memory limit of at least {} MiB for the "
                            "distances, found {} MiB: raise it (--memory)",
                            name, (needed >> 20) + 1, memory_bytes >> 20));
  }
  std::sort(labels.begin(), labels.end());
  return std::unique_ptr<DistanceSource>(
      new DistanceSource(name, std::move(volume), grid, std::move(labels)));
}

DistanceSource::DistanceSource(const std::string& name, std::unique_ptr<VolumeSource> volume,
                               const VolumeGrid& grid, std::vector<int64_t> labels)
    : name_(name),
      volume_(std::move(volume)),
      header_(volume_->header()),
      labels_(std::move(labels)) {
  header_.grid = grid;
  header_.type = VoxelType::f32;
  header_.slope = 1;
  header_.intercept = 0;
}

bool DistanceSource::has_label(double value) const {
  if (std::isnan(value)) return false;
  if (labels_.empty()) return value != 0;
  return std::binary_search(labels_.begin(), labels_.end(), value,
                            [](double a, double b) { return a < b; });
}

uint64_t DistanceSource::resident_bytes() const {
  return volume_->resident_bytes() + voxels_of(header_.grid) * sizeof(float) +
         SliceWindow(*volume_).memory_bytes(1);
}

Result<void> DistanceSource::compute() {
  const Index3 n = header_.grid.voxels;
  SliceWindow window(*volume_);
  std::vector<float> voxels;
  voxels.reserve(static_cast<size_t>(voxels_of(header_.grid)));
  bool has_inside = false, has_outside = false;
  for (int32_t z = 0; z < n.z; ++z) {
    if (auto held = window.move_to({z, z + 1}); !held) return held;
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const double value = window.at(x, y, z);
        const bool is_label = value == std::floor(value) && std::abs(value) <= kMaxLabel;
        if (!is_label && !std::isnan(value)) {
          return fail(Status::malformed_volume,
                      fmt::format("field '{}': expected labels, which are integers of at most "
                                  "±2^53, found {}",
                                  name_, value));
        }
        const bool is_inside = has_label(value);
        (is_inside ? has_inside : has_outside) = true;
        voxels.push_back(is_inside ? kInside : kOutside);
      }
    }
  }
  if (!has_inside || !has_outside) {
    return fail(Status::malformed_volume,
                fmt::format("field '{}': expected voxels with and without the labels, found only "
                            "voxels {}",
                            name_, has_inside ? "with them" : "without them"));
  }
  signed_distances(n, header_.grid.spacing, voxels);
  distances_ = std::move(voxels);
  return {};
}

Result<void> DistanceSource::read_slices(int32_t first, int32_t count, std::span<std::byte> out) {
  if (distances_.empty()) {
    if (auto computed = compute(); !computed) return computed;
  }
  const Index3 n = header_.grid.voxels;
  const size_t slice = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  std::memcpy(out.data(), &distances_[static_cast<size_t>(first) * slice],
              static_cast<size_t>(count) * slice * sizeof(float));
  return {};
}

}  // namespace isosplat
