#include "native/builder/clamped_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace isosplat {

Result<ClampedSource> ClampedSource::create(VolumeSource& volume, ValueRange range) {
  const VolumeHeader& header = volume.header();
  const double a = (range.low - header.intercept) / header.slope;
  const double b = (range.high - header.intercept) / header.slope;
  double low = std::min(a, b), high = std::max(a, b);
  with_voxel_type(header.type, [&]<class T>(T) {
    using Limits = std::numeric_limits<T>;
    if constexpr (std::is_integral_v<T>) {
      // Double precision cannot represent the greatest 64-bit integers, so the limit is a double
      // below them.
      const auto greatest = static_cast<uint64_t>(Limits::max());
      const auto most = static_cast<double>(sizeof(T) == 8 ? greatest / 4096 * 4096 : greatest);
      low = std::max(std::ceil(low), static_cast<double>(Limits::lowest()));
      high = std::min(std::floor(high), most);
    } else {
      // Rounds the limits to the type of the voxels, since voxels are compared with them.
      low = static_cast<double>(static_cast<T>(std::max<double>(low, Limits::lowest())));
      high = static_cast<double>(static_cast<T>(std::min<double>(high, Limits::max())));
    }
  });
  if (!(low < high)) {
    return fail(Status::invalid_argument,
                fmt::format("--range {},{}: expected a range with several values of the volume "
                            "'{}', whose voxels are of type {} with slope {} and intercept {}: "
                            "give another range",
                            range.low, range.high, header.name, voxel_type_name(header.type),
                            header.slope, header.intercept));
  }
  return ClampedSource(volume, low, high);
}

ClampedSource::ClampedSource(VolumeSource& volume, double low, double high)
    : volume_(volume),
      low_(low),
      high_(high),
      of_slices_(static_cast<size_t>(volume.header().grid.voxels.z)),
      counted_rows_(of_slices_.size()) {}

Result<void> ClampedSource::read_slices(int32_t first, int32_t count, std::span<std::byte> out) {
  return read_rows({first, count, 0, header().grid.voxels.y}, out);
}

Result<void> ClampedSource::read_rows(const SliceRows& part, std::span<std::byte> out) {
  if (auto read = volume_.read_rows(part, out); !read) return read;
  with_voxel_type(header().type, [&]<class T>(T) {
    const T low = static_cast<T>(low_), high = static_cast<T>(high_);
    auto* voxels = reinterpret_cast<T*>(out.data());
    const auto row = static_cast<size_t>(header().grid.voxels.x);
    for (int32_t z = part.first_slice; z < part.first_slice + part.slices; ++z) {
      ClampedVoxels& clamped = of_slices_[static_cast<size_t>(z)];
      int32_t& counted = counted_rows_[static_cast<size_t>(z)];
      for (int32_t y = part.first_row; y < part.first_row + part.rows; ++y, voxels += row) {
        uint64_t below = 0, above = 0;
        for (size_t i = 0; i < row; ++i) {
          const T voxel = voxels[i];
          if constexpr (std::is_floating_point_v<T>) {
            if (!has_value(voxel)) continue;
          }
          below += voxel < low;
          above += voxel > high;
          voxels[i] = std::clamp(voxel, low, high);
        }
        if (y != counted) continue;
        clamped.below += below;
        clamped.above += above;
        ++counted;
      }
    }
  });
  return {};
}

std::shared_ptr<const VoxelScan> ClampedSource::all_values() const {
  auto scan = std::make_shared<VoxelScan>(header().type);
  with_voxel_type(header().type, [&]<class T>(T) {
    const T low = static_cast<T>(low_), high = static_cast<T>(high_);
    std::vector<T> voxels{low, high};
    if constexpr (std::is_integral_v<T>) {
      voxels.push_back(static_cast<T>(low + 1));
    } else {
      // More different values than a lattice may have, so that the values are rounded over the
      // range.
      for (size_t i = 1; i <= DistinctValues::kMax; ++i) {
        const double part = static_cast<double>(i) / (DistinctValues::kMax + 1.0);
        voxels.push_back(static_cast<T>(low_ + (high_ - low_) * part * part));
      }
      voxels.push_back(std::numeric_limits<T>::quiet_NaN());
    }
    scan->add(std::as_bytes(std::span(voxels)));
  });
  return scan;
}

ClampedVoxels ClampedSource::clamped() const {
  ClampedVoxels all;
  for (const ClampedVoxels& slice : of_slices_) {
    all.below += slice.below;
    all.above += slice.above;
  }
  return all;
}

void ClampedSource::add_slices(std::span<const ClampedVoxels> of_slices) {
  // Several processes may have read a slice. Their counts of it are equal.
  for (size_t z = 0; z < std::min(of_slices_.size(), of_slices.size()); ++z) {
    of_slices_[z].below = std::max(of_slices_[z].below, of_slices[z].below);
    of_slices_[z].above = std::max(of_slices_[z].above, of_slices[z].above);
  }
}

}  // namespace isosplat
