#include "native/import/missing_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace isosplat {
namespace {

constexpr int32_t kSampledSlices = 64;
constexpr double kLeastShare = 5e-4;  // of the sampled voxels

bool is_float(VoxelType type) {
  return type == VoxelType::f32 || type == VoxelType::f64;
}

/// The floating-point type that holds all values of a type.
VoxelType type_with_nan(VoxelType type) {
  if (is_float(type)) return type;
  return voxel_bytes(type) <= 2 ? VoxelType::f32 : VoxelType::f64;
}

/// Whether a voxel is the value that a header or a person wrote down, perhaps with fewer digits.
template <class T>
bool is_same(const VolumeHeader& header, T voxel, double missing) {
  const double tolerance =
      std::is_floating_point_v<T> ? 3e-7 * std::abs(missing) : 1e-3 * std::abs(header.slope);
  return std::abs(header.value(static_cast<double>(voxel)) - missing) <= tolerance;
}

class MissingSource : public VolumeSource {
 public:
  MissingSource(std::unique_ptr<VolumeSource> source, double missing)
      : source_(std::move(source)), missing_(missing), header_(source_->header()) {
    header_.type = type_with_nan(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const VoxelType type = source_->header().type;
    if (out.size() % voxel_bytes(header_.type) != 0) {
      return fail(Status::invalid_argument, "slices outside the volume were asked for");
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
      const To to = is_same(header_, from, missing_) ? std::numeric_limits<To>::quiet_NaN()
                                                     : static_cast<To>(from);
      std::memcpy(out.data() + i * sizeof(To), &to, sizeof(To));
    }
  }

  std::unique_ptr<VolumeSource> source_;
  double missing_;
  VolumeHeader header_;
  std::vector<std::byte> scratch_;
};

/// One end of the range of the values seen: the extreme, how many voxels have it, and the one next
/// to it.
struct End {
  double value = std::numeric_limits<double>::infinity();
  double next = std::numeric_limits<double>::infinity();
  uint64_t count = 0;

  void see(double v) {
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

struct Seen {
  End low, high;  ///< of high, all values are negated
  uint64_t count = 0;
};

Result<Seen> sample(VolumeSource& source) {
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t voxels = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  std::vector<std::byte> slice(voxels * voxel_bytes(header.type));
  Seen seen;
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
        seen.low.see(v);
        seen.high.see(-v);
        ++seen.count;
      }
    });
  }
  return seen;
}

bool is_common_fill(double value) {
  for (const double known : {999.0, 9999.0, 99999.0, 999999.0, 32768.0}) {
    if (std::abs(value) == known) return true;
  }
  return std::abs(value) >= 1e20;  // 1e20, 9.96921e36 (netCDF), 3.4e38
}

/// The value at one end of the range that stands for none. `rest`: the range of all others.
/// `is_sure` becomes false where it may as well be a value.
std::optional<double> fill_at(const End& end, double rest, uint64_t count, double sign,
                              bool& is_sure) {
  const auto least = std::max(8.0, kLeastShare * static_cast<double>(count));
  const double gap = end.next - end.value;
  if (!std::isfinite(end.next) || !(rest > 0) || static_cast<double>(end.count) < least) {
    return std::nullopt;
  }
  const double value = sign * end.value;
  is_sure = value != 0;
  if (is_common_fill(value) ? gap > 0.1 * rest : gap > 10 * rest) return value;
  return std::nullopt;
}

}  // namespace

Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options) {
  const VoxelType type = volume.source->header().type;
  std::optional<double> missing = options.missing_value;
  if (missing) {
    volume.notes.push_back(fmt::format(
        "voxels of the value {:g} are taken to have none, as --missing-value says", *missing));
  } else if (!options.finds_missing_values) {
    return volume;
  } else if (volume.fill_value) {
    missing = volume.fill_value;
    volume.notes.push_back(
        fmt::format("voxels of the value {:g} are taken to have none, as the "
                    "file's header says; --missing-value none keeps them",
                    *missing));
  } else if (is_float(type)) {
    const auto seen = sample(*volume.source);
    if (!seen) return tl::unexpected(seen.error());
    bool is_sure = true;
    missing = fill_at(seen->low, -seen->high.value - seen->low.next, seen->count, 1, is_sure);
    if (!missing) {
      missing = fill_at(seen->high, -seen->high.next - seen->low.value, seen->count, -1, is_sure);
    }
    if (missing && !is_sure) {
      volume.notes.push_back(fmt::format(
          "the value {:g} lies far outside the range of all others: if it stands for no "
          "value, say so with --missing-value={:g}",
          *missing, *missing));
      return volume;
    }
    if (missing) {
      volume.notes.push_back(
          fmt::format("voxels of the value {:g}, far outside the range of all "
                      "others, are taken to have none; --missing-value none "
                      "keeps them",
                      *missing));
    }
  }
  if (!missing) return volume;
  volume.source = std::make_unique<MissingSource>(std::move(volume.source), *missing);
  return volume;
}

}  // namespace isosplat
