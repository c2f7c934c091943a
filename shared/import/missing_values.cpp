#include "shared/import/missing_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "shared/import/absent_voxels.h"

namespace isosplat {
namespace {

constexpr int32_t kSampledSlices = 64;
constexpr double kMinShare = 5e-4;  // of the sampled voxels

bool is_float(VoxelType type) {
  return type == VoxelType::f32 || type == VoxelType::f64;
}

/// Whether a voxel has the given value, which a header or the user may have written with fewer
/// digits.
template <class T>
bool is_in(const VolumeHeader& header, T voxel, const FillValue& fill) {
  const double value = header.value(static_cast<double>(voxel));
  const double tolerance = std::is_floating_point_v<T>
                               ? 3e-7 * std::max(std::abs(fill.low), std::abs(fill.high))
                               : 1e-3 * std::abs(header.slope);
  return value >= fill.low - tolerance && value <= fill.high + tolerance;
}

class MissingSource : public VolumeSource {
 public:
  MissingSource(std::unique_ptr<VolumeSource> source, const FillValue& missing)
      : source_(std::move(source)), missing_(missing), header_(source_->header()) {
    header_.type = type_with_absent(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const VoxelType type = source_->header().type;
    if (out.size() % voxel_bytes(header_.type) != 0) {
      return fail(Status::invalid_argument, "expected a range of slices inside the volume");
    }
    const size_t voxels = out.size() / voxel_bytes(header_.type);
    std::span<std::byte> in = out;
    if (type != header_.type) {
      scratch_.resize(voxels * voxel_bytes(type));
      in = scratch_;
    }
    if (auto read = source_->read_slices(first, count, in); !read) return read;
    with_voxel_type(type, [&](auto zero) {
      using From = decltype(zero);
      if (header_.type == VoxelType::f32) {
        convert<From, float>(in, out, voxels);
      } else {
        convert<From, double>(in, out, voxels);
      }
    });
    return {};
  }

  uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return source_->files(); }

 private:
  template <class From, class To>
  void convert(std::span<const std::byte> in, std::span<std::byte> out, size_t voxels) const {
    for (size_t i = 0; i < voxels; ++i) {
      From from;
      std::memcpy(&from, in.data() + i * sizeof(From), sizeof(From));
      const To to = is_in(header_, from, missing_) ? std::numeric_limits<To>::quiet_NaN()
                                                   : static_cast<To>(from);
      std::memcpy(out.data() + i * sizeof(To), &to, sizeof(To));
    }
  }

  std::unique_ptr<VolumeSource> source_;
  FillValue missing_;
  VolumeHeader header_;
  std::vector<std::byte> scratch_;
};

/// Statistics of one end of the value range: the extreme value, the number of voxels with it, and
/// the next value.
struct RangeEnd {
  double value = std::numeric_limits<double>::infinity();
  double next = std::numeric_limits<double>::infinity();
  uint64_t count = 0;

  void add(double v) {
    if (v < value) {
      next = value;
      value = v;
      count = 1;
    } else if (v == value) {
      ++count;
    } else if (v < next) {
      next = v;
    }
  }
};

struct Statistics {
  RangeEnd low, high;  ///< the values of `high` are negated
  uint64_t count = 0;
  uint64_t filled = 0;  ///< voxels with a fill value; they are excluded from the statistics
};

Result<Statistics> sample(VolumeSource& source,
                          const std::optional<FillValue>& fill = std::nullopt) {
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t voxels = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  std::vector<std::byte> slice(voxels * voxel_bytes(header.type));
  Statistics statistics;
  const int32_t slices = std::min(n.z, kSampledSlices);
  for (int32_t i = 0; i < slices; ++i) {
    const auto z = static_cast<int32_t>(int64_t{i} * (n.z - 1) / std::max(slices - 1, 1));
    if (auto read = source.read_slices(z, 1, slice); !read) return tl::unexpected(read.error());
    with_voxel_type(header.type, [&](auto zero) {
      using T = decltype(zero);
      for (size_t k = 0; k < voxels; ++k) {
        T voxel;
        std::memcpy(&voxel, slice.data() + k * sizeof(T), sizeof(T));
        const double v = header.value(static_cast<double>(voxel));
        if (!std::isfinite(v)) continue;
        if (fill && is_in(header, voxel, *fill)) {
          ++statistics.filled;
          continue;
        }
        statistics.low.add(v);
        statistics.high.add(-v);
        ++statistics.count;
      }
    });
  }
  return statistics;
}

bool is_common_fill(double value) {
  for (const double known : {999.0, 9999.0, 99999.0, 999999.0, 32768.0}) {
    if (std::abs(value) == known) return true;
  }
  return std::abs(value) >= 1e20;  // 1e20, 9.96921e36 (netCDF), 3.4e38
}

/// For integers also the ends of the types' ranges, and the values that CT scanners write outside
/// their circular field of view.
bool is_common_integer_fill(double value) {
  for (const double known :
       {-2000.0, -3024.0, -32767.0, 32767.0, 65535.0, -2147483648.0, 2147483647.0, 4294967295.0}) {
    if (value == known) return true;
  }
  return is_common_fill(value);
}

/// The value at one end of the range that stands for "no value". `rest`: the range of all other
/// values.
std::optional<double> fill_at(const RangeEnd& end, double rest, uint64_t count, double sign,
                              bool is_common(double)) {
  const auto min_count = std::max(8.0, kMinShare * static_cast<double>(count));
  const double gap = end.next - end.value;
  if (!std::isfinite(end.next) || !(rest > 0) || static_cast<double>(end.count) < min_count) {
    return std::nullopt;
  }
  const double value = sign * end.value;
  if (is_common(value) ? gap > 0.1 * rest : gap > 10 * rest) return value;
  return std::nullopt;
}

/// A single value that lies far outside the range of all others and that many voxels have.
std::optional<double> outlying_value(const Statistics& statistics, bool is_common(double)) {
  const auto low = fill_at(statistics.low, -statistics.high.value - statistics.low.next,
                           statistics.count, 1, is_common);
  if (low) return low;
  return fill_at(statistics.high, -statistics.high.next - statistics.low.value, statistics.count,
                 -1, is_common);
}

/// Whether a fill value lies apart from all other values: by more than 1/50 of their range.
bool lies_apart(const FillValue& fill, const Statistics& statistics) {
  const double low = statistics.low.value, high = -statistics.high.value;
  const double gap = std::max(low - fill.high, fill.low - high);
  return statistics.count > 0 && gap > 0.02 * (high - low);
}

std::string text_of(const FillValue& fill) {
  return fill.low == fill.high ? fmt::format("value {:.10g}", fill.low)
                               : fmt::format("values {:.10g} to {:.10g}", fill.low, fill.high);
}

OpenVolume without(OpenVolume volume, const FillValue& missing, const std::string& why) {
  volume.notes.push_back(fmt::format("voxels of the {}{}", text_of(missing), why));
  volume.source = std::make_unique<MissingSource>(std::move(volume.source), missing);
  return volume;
}

/// Applies a header's fill value that is not reliable.
Result<OpenVolume> with_padding(OpenVolume volume, const FillValue& fill) {
  const auto statistics = sample(*volume.source, fill);
  if (!statistics) return tl::unexpected(statistics.error());
  if (statistics->filled == 0) return volume;
  if (lies_apart(fill, *statistics)) {
    return without(std::move(volume), fill,
                   " have no value according to the file's header; --missing-value none keeps "
                   "them");
  }
  volume.notes.push_back(
      fmt::format("according to the file's header, voxels of the {} are padding: they are kept, "
                  "since other voxels have similar values; --missing-value={:.10g} removes them",
                  text_of(fill), fill.low));
  return volume;
}

}  // namespace

Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options) {
  const VoxelType type = volume.source->header().type;
  if (options.missing_value) {
    const double value = *options.missing_value;
    return without(std::move(volume), {value, value},
                   " have no value, as --missing-value requests");
  }
  if (!options.finds_missing_values) return volume;
  if (volume.fill_value && !volume.fill_value->is_certain) {
    const FillValue fill = *volume.fill_value;
    return with_padding(std::move(volume), fill);
  }
  if (volume.fill_value) {
    const FillValue fill = *volume.fill_value;
    return without(std::move(volume), fill,
                   " have no value according to the file's header; --missing-value none keeps "
                   "them");
  }
  if (voxel_bytes(type) == 1) return volume;  // 0 and 255 are ordinary values
  const auto statistics = sample(*volume.source);
  if (!statistics) return tl::unexpected(statistics.error());
  const auto value =
      outlying_value(*statistics, is_float(type) ? is_common_fill : is_common_integer_fill);
  if (!value) return volume;
  // Integers are often labels or saturated; a floating-point 0 is often a background.
  if (!is_float(type) || *value == 0) {
    volume.notes.push_back(
        fmt::format("the value {:.10g} lies far outside the range of all others: if it stands for "
                    "\"no value\", use --missing-value={:.10g}",
                    *value, *value));
    return volume;
  }
  return without(
      std::move(volume), {*value, *value},
      ", far outside the range of all others, have no value; --missing-value none keeps them");
}

}  // namespace isosplat
