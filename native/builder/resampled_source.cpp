#include "native/builder/resampled_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/core/unstructured/random_points.h"

namespace isosplat {
namespace {

constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();
constexpr int32_t kFewSlices = 4;
constexpr int32_t kMeasuredSlabs = 16, kPointsPerSlab = 256;

/// A position along an axis of n voxels: between voxel `low` and its neighbour, or at voxel `low`
/// if part is 0.
struct AxisPosition {
  int32_t low = 0;
  double part = 0;

  /// Positions within 10⁻⁶ of a voxel are at it, so that grids with common voxels share their
  /// values. The position is at most half a voxel outside.
  AxisPosition(double position, int32_t n) {
    const double inside = std::clamp(position, 0.0, n - 1.0), nearest = std::round(inside);
    if (std::abs(inside - nearest) <= 1e-6) {
      low = static_cast<int32_t>(nearest);
      return;
    }
    low = static_cast<int32_t>(inside);
    part = inside - low;
  }
};

bool is_in(double position, int32_t n) {
  return position >= -0.5 && position <= n - 0.5;
}

}  // namespace

ResampledSource::ResampledSource(std::unique_ptr<VolumeSource> volume, const VolumeGrid& from,
                                 const VolumeGrid& to)
    : volume_(std::move(volume)), header_(volume_->header()), window_(*volume_) {
  const Matrix3d inverse = from.dual_edges(), edges = to.cell_edges();
  Vec3d columns[3];
  for (size_t i = 0; i < 3; ++i) columns[i] = multiply_transposed(inverse, column(edges, i));
  to_volume_ = {columns[0].x, columns[1].x, columns[2].x, columns[0].y, columns[1].y,
                columns[2].y, columns[0].z, columns[1].z, columns[2].z};
  offset_ = multiply_transposed(inverse, to.origin - from.origin);
  header_.grid = to;
  header_.type = VoxelType::f32;
  header_.slope = 1;
  header_.intercept = 0;
}

Result<std::unique_ptr<ResampledSource>> ResampledSource::create(
    std::unique_ptr<VolumeSource> volume, const VolumeGrid& from, const VolumeGrid& to,
    uint64_t memory_bytes) {
  std::unique_ptr<ResampledSource> source(new ResampledSource(std::move(volume), from, to));
  const int32_t slices = source->volume_->header().grid.voxels.z;
  for (int32_t z = 0; z < to.voxels.z; ++z) {
    const Slices crossed = source->crossed(z, z, 0, to.voxels.y - 1);
    source->most_slices_ = std::max(source->most_slices_, crossed.end - crossed.first);
  }
  const uint64_t slice = source->window_.slice_bytes();
  const bool is_descending = source->to_volume_[8] < 0;
  source->holds_all_ = (is_descending || source->most_slices_ > kFewSlices) &&
                       slice * static_cast<uint64_t>(slices) <= memory_bytes / 4;
  // While the window moves, there are two of them.
  const uint64_t needed = 2 * slice * static_cast<uint64_t>(source->most_slices_);
  if (!source->holds_all_ && needed > memory_bytes / 2) {
    return fail(Status::out_of_memory,
                fmt::format("'{}': expected a volume that can be resampled in {} MiB, found one "
                            "that needs {} MiB, since its axes are turned against the grid: allow "
                            "more memory, or resample it before",
                            source->header_.name, memory_bytes / 2 >> 20, needed >> 20));
  }
  return source;
}

uint64_t ResampledSource::resident_bytes() const {
  const int32_t slices = holds_all_ ? volume_->header().grid.voxels.z : 2 * most_slices_;
  return volume_->resident_bytes() + window_.slice_bytes() * static_cast<uint64_t>(slices);
}

ResampledSource::Slices ResampledSource::crossed(double first, double last, double first_row,
                                                 double last_row) const {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double x : {0.0, header_.grid.voxels.x - 1.0}) {
    for (const double y : {first_row, last_row}) {
      for (const double z : {first, last}) {
        const double k = (multiply(to_volume_, {x, y, z}) + offset_).z;
        low = std::min(low, k);
        high = std::max(high, k);
      }
    }
  }
  const double n = volume_->header().grid.voxels.z;
  if (!(high >= -0.5 && low <= n - 0.5)) return {};
  return {static_cast<int32_t>(std::floor(std::clamp(low, 0.0, n - 1))),
          static_cast<int32_t>(std::ceil(std::clamp(high, 0.0, n - 1))) + 1};
}

Result<void> ResampledSource::hold(Slices slices) {
  if (slices.first == slices.end) return {};
  if (holds_all_) slices = {0, volume_->header().grid.voxels.z};
  return window_.move_to(slices.first, slices.end);
}

float ResampledSource::value(Vec3d index) const {
  const Index3 n = volume_->header().grid.voxels;
  const Vec3d at = multiply(to_volume_, index) + offset_;
  if (!is_in(at.x, n.x) || !is_in(at.y, n.y) || !is_in(at.z, n.z)) return kNoValue;
  const AxisPosition x(at.x, n.x), y(at.y, n.y), z(at.z, n.z);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const double weight =
        (dx ? x.part : 1 - x.part) * (dy ? y.part : 1 - y.part) * (dz ? z.part : 1 - z.part);
    // Voxels without weight may be outside, or have no value.
    if (weight > 0) sum += weight * window_.at(x.low + dx, y.low + dy, z.low + dz);
  }
  return static_cast<float>(sum);
}

Result<void> ResampledSource::read_rows(const SliceRows& part, std::span<std::byte> out) {
  auto* values = reinterpret_cast<float*>(out.data());
  const int32_t end_row = part.first_row + part.rows;
  for (int32_t z = part.first_slice; z < part.first_slice + part.slices; ++z) {
    if (auto held = hold(crossed(z, z, part.first_row, end_row - 1)); !held) return held;
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
  RandomPoints random(1);
  ResamplingError error;
  double squares = 0;
  int32_t with_value = 0, without = 0;
  for (int32_t slab = 0; slab < kMeasuredSlabs; ++slab) {
    const auto z = static_cast<int32_t>(int64_t{slab} * (n.z - 1) / kMeasuredSlabs);
    if (auto held = hold(crossed(z, z + 1, 0, n.y - 1)); !held) return tl::unexpected(held.error());
    for (int32_t point = 0; point < kPointsPerSlab; ++point) {
      const Vec3d part = random.in_unit_cube();
      const Vec3d at{part.x * (n.x - 1), part.y * (n.y - 1), z + part.z};
      const double expected = value(at);
      if (std::isnan(expected)) {
        ++without;
        continue;
      }
      const Vec3d low{std::floor(at.x), std::floor(at.y), static_cast<double>(z)};
      double found = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3d step{static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1),
                         static_cast<double>(corner >> 2)};
        const auto weight = [](double position, double end) {
          return end > 0 ? position : 1 - position;
        };
        found += weight(at.x - low.x, step.x) * weight(at.y - low.y, step.y) *
                 weight(part.z, step.z) * value(low + step);
      }
      if (std::isnan(found)) continue;  // at the border of the volume
      ++with_value;
      squares += (found - expected) * (found - expected);
      error.max = std::max(error.max, std::abs(found - expected));
    }
  }
  if (with_value > 0) error.rms = std::sqrt(squares / with_value);
  error.outside = static_cast<double>(without) / (kMeasuredSlabs * kPointsPerSlab);
  return error;
}

}  // namespace isosplat
