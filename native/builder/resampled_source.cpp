#include "native/builder/resampled_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/core/unstructured/random_points.h"

namespace isosplat {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr int32_t kFewSlices = 4;
constexpr int32_t kMeasuredSlabs = 16;
constexpr size_t kPointsPerSlab = 256;
/// Positions that are equal but for rounding, in voxels.
constexpr double kRounding = 1e-6;

/// A position along an axis of n voxels: between voxel `low` and its neighbour, or at voxel `low`
/// if part is 0.
struct AxisPosition {
  int32_t low = 0;
  double part = 0;

  /// Positions that are equal to a voxel's but for rounding are at it, so that grids with common
  /// voxels share their values.
  AxisPosition(double position, int32_t n) {
    const double inside = std::clamp(position, 0.0, n - 1.0), nearest = std::round(inside);
    if (std::abs(inside - nearest) <= kRounding) {
      low = static_cast<int32_t>(nearest);
      return;
    }
    low = static_cast<int32_t>(inside);
    part = inside - low;
  }

  /// The voxels on both sides.
  Slices around() const { return {low, low + (part > 0 ? 2 : 1)}; }
};

bool is_in(double position, int32_t n, double reach) {
  return position >= -reach && position <= n - 1 + reach;
}

double weight_at(double part, bool is_high) {
  return is_high ? part : 1 - part;
}

}  // namespace

ResampledSource::ResampledSource(std::unique_ptr<VolumeSource> volume, const VolumeGrid& from,
                                 const VolumeGrid& to, const ResamplingOptions& options)
    : volume_(std::move(volume)),
      header_(volume_->header()),
      nearest_(options.nearest),
      window_(*volume_) {
  const Matrix3d inverse = from.dual_edges(), edges = to.cell_edges();
  Vec3d columns[3];
  for (size_t i = 0; i < 3; ++i) columns[i] = multiply_transposed(inverse, column(edges, i));
  to_volume_ = {columns[0].x, columns[1].x, columns[2].x, columns[0].y, columns[1].y,
                columns[2].y, columns[0].z, columns[1].z, columns[2].z};
  offset_ = multiply_transposed(inverse, to.origin - from.origin);
  const auto beyond = [&](size_t row) {
    const double grid_voxel =
        std::abs(to_volume_[row]) + std::abs(to_volume_[row + 1]) + std::abs(to_volume_[row + 2]);
    return options.voxels + options.grid_voxels * grid_voxel + kRounding;
  };
  reach_ = {beyond(0), beyond(3), beyond(6)};
  header_.grid = to;
  header_.type = VoxelType::f64;
  header_.slope = 1;
  header_.intercept = 0;
}

Result<std::unique_ptr<ResampledSource>> ResampledSource::create(
    const std::string& name, std::unique_ptr<VolumeSource> volume, const VolumeGrid& from,
    const VolumeGrid& to, uint64_t memory_bytes, const ResamplingOptions& options) {
  std::unique_ptr<ResampledSource> source(
      new ResampledSource(std::move(volume), from, to, options));
  const double last_row = to.voxels.y - 1.0;
  for (int32_t z = 0; z < to.voxels.z; ++z) {
    const int32_t slices = source->crossed(z, z, 0, last_row).count();
    source->most_slices_ = std::max(source->most_slices_, slices);
  }
  const bool is_descending = source->to_volume_[8] < 0;
  const Slices all = source->crossed(0, to.voxels.z - 1.0, 0, last_row);
  const uint64_t all_bytes = source->window_.slice_bytes() * static_cast<uint64_t>(all.count());
  if ((is_descending || source->most_slices_ > kFewSlices) && all_bytes <= memory_bytes / 4) {
    source->all_ = all;
    return source;
  }
  const uint64_t needed = source->window_.memory_bytes(source->most_slices_);
  if (needed > memory_bytes / 2) {
    return fail(
        Status::out_of_memory,
        fmt::format("field '{}': expected at least {} MiB of memory to resample it, since "
                    "a slice of the volume crosses {} of its slices, found {} MiB: raise "
                    "the limit of the memory, or resample it before",
                    name, (2 * needed >> 20) + 1, source->most_slices_, memory_bytes >> 20));
  }
  return source;
}

uint64_t ResampledSource::resident_bytes() const {
  const uint64_t window = all_.count() > 0
                              ? window_.slice_bytes() * static_cast<uint64_t>(all_.count() + 1)
                              : window_.memory_bytes(most_slices_);
  return volume_->resident_bytes() + window;
}

Slices ResampledSource::crossed(double first, double last, double first_row,
                                double last_row) const {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double x : {0.0, header_.grid.voxels.x - 1.0}) {
    for (const double y : {first_row, last_row}) {
      for (const double z : {first, last}) {
        const double k = in_volume({x, y, z}).z;
        low = std::min(low, k);
        high = std::max(high, k);
      }
    }
  }
  const int32_t n = volume_->header().grid.voxels.z;
  // Positions between the corners may be rounded to beyond them.
  low -= kRounding;
  high += kRounding;
  if (!(high >= -reach_.z && low <= n - 1 + reach_.z)) return {};
  return {AxisPosition(low, n).around().first, AxisPosition(high, n).around().end};
}

Result<void> ResampledSource::hold(Slices slices) {
  if (slices.count() == 0) return {};
  return window_.move_to(all_.count() > 0 ? all_ : slices);
}

double ResampledSource::value(Vec3d index) const {
  const Index3 n = volume_->header().grid.voxels;
  const Vec3d at = in_volume(index);
  if (!is_in(at.x, n.x, reach_.x) || !is_in(at.y, n.y, reach_.y) || !is_in(at.z, n.z, reach_.z)) {
    return kNoValue;
  }
  const AxisPosition x(at.x, n.x), y(at.y, n.y), z(at.z, n.z);
  if (nearest_) {
    const auto nearest = [](const AxisPosition& along) {
      return along.low + (along.part >= 0.5 ? 1 : 0);
    };
    return window_.at(nearest(x), nearest(y), nearest(z));
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight = weight_at(x.part, dx) * weight_at(y.part, dy) * weight_at(z.part, dz);
    // Voxels without weight may be outside, or have no value.
    if (weight > 0) sum += weight * window_.at(x.low + dx, y.low + dy, z.low + dz);
  }
  return sum;
}

Result<void> ResampledSource::read_rows(const SliceRows& part, std::span<std::byte> out) {
  auto* values = reinterpret_cast<double*>(out.data());
  const int32_t end_row = part.first_row + part.rows;
  for (int32_t z = part.first_slice; z < part.first_slice + part.slices; ++z) {
    const Slices slices = crossed(z, z, part.first_row, end_row - 1);
    if (slices.count() == 0) {
      values = std::fill_n(values, SliceRows{z, 1, 0, part.rows}.voxels(header_.grid.voxels.x),
                           kNoValue);
      continue;
    }
    if (auto held = hold(slices); !held) return held;
    for (int32_t y = part.first_row; y < end_row; ++y) {
      for (int32_t x = 0; x < header_.grid.voxels.x; ++x) {
        *values++ = value({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
      }
    }
  }
  return {};
}

Result<ResamplingError> ResampledSource::measure() {
  const Index3 n = header_.grid.voxels;
  const int32_t field_slices = volume_->header().grid.voxels.z;
  RandomPoints random(1);
  ResamplingError error;
  double squares = 0;
  size_t with_value = 0, without = 0;
  struct Point {
    Vec3d at, part;
    double found = 0;
  };
  for (int32_t slab = 0; slab < kMeasuredSlabs; ++slab) {
    const auto z = static_cast<int32_t>(int64_t{slab} * (n.z - 1) / kMeasuredSlabs);
    std::array<Point, kPointsPerSlab> points;
    for (Point& point : points) {
      const Vec3d random_part = random.in_unit_cube();
      const Vec3d at{random_part.x * (n.x - 1), random_part.y * (n.y - 1), z + random_part.z};
      point = {at, {at.x - std::floor(at.x), at.y - std::floor(at.y), random_part.z}};
    }
    // One slice of the grid after the other, so that no more of the volume is in memory than while
    // it is read.
    for (const int32_t end : {0, 1}) {
      const Slices slices = crossed(z + end, z + end, 0, n.y - 1);
      if (auto held = hold(slices); !held) return tl::unexpected(held.error());
      for (Point& point : points) {
        for (int corner = 0; corner < 4; ++corner) {
          const int dx = corner & 1, dy = corner >> 1;
          const double weight = weight_at(point.part.x, dx) * weight_at(point.part.y, dy) *
                                weight_at(point.part.z, end);
          const Vec3d node{std::floor(point.at.x) + dx, std::floor(point.at.y) + dy,
                           static_cast<double>(z + end)};
          point.found += weight * (slices.count() > 0 ? value(node) : kNoValue);
        }
      }
    }
    std::sort(points.begin(), points.end(), [&](const Point& a, const Point& b) {
      return in_volume(a.at).z < in_volume(b.at).z;
    });
    for (const Point& point : points) {
      const double k = in_volume(point.at).z;
      double expected = kNoValue;
      if (is_in(k, field_slices, reach_.z)) {
        if (auto held = hold(AxisPosition(k, field_slices).around()); !held) {
          return tl::unexpected(held.error());
        }
        expected = value(point.at);
      }
      if (std::isnan(expected)) {
        ++without;
      } else if (!std::isnan(point.found)) {
        ++with_value;
        squares += (point.found - expected) * (point.found - expected);
        error.max = std::max(error.max, std::abs(point.found - expected));
      }
    }
  }
  if (with_value > 0) error.rms = std::sqrt(squares / static_cast<double>(with_value));
  error.outside = static_cast<double>(without) / (kMeasuredSlabs * kPointsPerSlab);
  return error;
}

}  // namespace isosplat
