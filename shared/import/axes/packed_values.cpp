#include "shared/import/axes/packed_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "shared/import/text/header_text.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/voxels/absent_voxels.h"

// netCDF's conventions for values (NUG, appendix A; CF, chapters 2.5 and 8.1).
namespace isosplat::import {
namespace {

bool is_float(VoxelType type) {
  return type == VoxelType::f32 || type == VoxelType::f64;
}

/// The unsigned type of a signed one, and the reverse; other types as they are.
VoxelType with_sign(VoxelType type, bool is_signed) {
  constexpr VoxelType kPairs[][2] = {{VoxelType::u8, VoxelType::i8},
                                     {VoxelType::u16, VoxelType::i16},
                                     {VoxelType::u32, VoxelType::i32},
                                     {VoxelType::u64, VoxelType::i64}};
  for (const auto& [positive, negative] : kPairs) {
    if (type == positive || type == negative) return is_signed ? negative : positive;
  }
  return type;
}

/// A number as a value of this type: integers wrap, so that -1 of an unsigned byte is 255.
double in_type(VoxelType type, double number) {
  if (is_float(type) || std::abs(number) > 9e15 || std::round(number) != number) return number;
  return with_voxel_type(type, [&]<class T>(T) {
    if constexpr (std::is_integral_v<T>) {
      return static_cast<double>(static_cast<T>(static_cast<int64_t>(number)));
    } else {
      return number;
    }
  });
}

class MissingSource : public VolumeSource {
 public:
  MissingSource(std::unique_ptr<VolumeSource> source, MissingNumbers missing)
      : source_(std::move(source)), missing_(std::move(missing)), header_(source_->header()) {
    header_.type = type_with_absent(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }
  uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return source_->files(); }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return read_rows({first, count, 0, header_.grid.voxels.y}, out);
  }

  bool reads_rows() const override { return source_->reads_rows(); }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    const VoxelType type = source_->header().type;
    const size_t voxels = out.size() / voxel_bytes(header_.type);
    stored_.resize(voxels * voxel_bytes(type));
    if (auto read = source_->read_rows(part, stored_); !read) return read;
    convert_voxels(type, stored_, header_.type, out);
    with_voxel_type(type, [&]<class T>(T) { mark<T>(voxels, out); });
    return {};
  }

 private:
  template <class T>
  void mark(size_t voxels, std::span<std::byte> out) const {
    // Attributes often have more digits than the voxels' type, and may not fit it.
    const auto in_voxel_type = [](double number) -> std::optional<T> {
      constexpr auto kLowest = static_cast<double>(std::numeric_limits<T>::lowest());
      if constexpr (std::is_floating_point_v<T>) {
        return static_cast<T>(std::clamp(number, kLowest, -kLowest));
      } else {
        const double end = std::ldexp(1.0, std::numeric_limits<T>::digits);
        if (number < kLowest || number >= end || std::floor(number) != number) return std::nullopt;
        return static_cast<T>(number);
      }
    };
    std::vector<T> values;
    for (const double value : missing_.values) {
      if (const auto known = in_voxel_type(value)) values.push_back(*known);
    }
    const auto limit = [&](const std::optional<double>& number) -> std::optional<double> {
      if (!number || !std::is_floating_point_v<T>) return number;
      return static_cast<double>(*in_voxel_type(*number));
    };
    const auto least = limit(missing_.least), greatest = limit(missing_.greatest);
    const size_t bytes = voxel_bytes(header_.type);
    for (size_t i = 0; i < voxels; ++i) {
      T voxel;
      std::memcpy(&voxel, stored_.data() + i * sizeof(T), sizeof(T));
      const auto number = static_cast<double>(voxel);
      const bool is_missing = std::find(values.begin(), values.end(), voxel) != values.end() ||
                              (least && number < *least) || (greatest && number > *greatest);
      if (is_missing) make_absent(header_.type, out.subspan(i * bytes, bytes));
    }
  }

  std::unique_ptr<VolumeSource> source_;
  MissingNumbers missing_;
  VolumeHeader header_;
  std::vector<std::byte> stored_;
};

}  // namespace

MissingNumbers packed_values(const ArrayAttributes& attributes, bool is_unsigned,
                             StoredVoxels& stored) {
  const auto numbers = [&](const char* name) {
    auto found = attributes.numbers(name).value_or(std::vector<double>());
    std::erase_if(found, [](double number) { return !std::isfinite(number); });
    return found;
  };
  const auto number = [&](const char* name) -> std::optional<double> {
    const auto found = numbers(name);
    return found.size() == 1 ? std::optional(found.front()) : std::nullopt;
  };
  if (const auto slope = number("scale_factor"); slope && *slope != 0) stored.slope = *slope;
  if (const auto intercept = number("add_offset")) stored.intercept = *intercept;
  const std::string sign = lower_case(attributes.text("_Unsigned"));
  if (sign == "true" || is_unsigned) stored.type = with_sign(stored.type, false);
  if (sign == "false") stored.type = with_sign(stored.type, true);

  MissingNumbers missing;
  for (const char* name : {"_FillValue", "missing_value"}) {
    for (const double value : numbers(name)) {
      const double known = in_type(stored.type, value);
      auto& values = missing.values;
      if (std::find(values.begin(), values.end(), known) == values.end()) values.push_back(known);
    }
  }
  // If the stored numbers are integers and the limits are floating-point numbers, these are limits
  // of the values.
  const auto limit = [&](const char* name, size_t i, size_t count) -> std::optional<double> {
    const auto found = numbers(name);
    if (found.size() != count) return std::nullopt;
    const auto type = attributes.number_type(name);
    const bool is_unpacked = type && is_float(*type) && !is_float(stored.type);
    return is_unpacked ? (found[i] - stored.intercept) / stored.slope
                       : in_type(stored.type, found[i]);
  };
  missing.least = limit("valid_range", 0, 2);
  missing.greatest = limit("valid_range", 1, 2);
  if (const auto least = limit("valid_min", 0, 1)) missing.least = least;
  if (const auto greatest = limit("valid_max", 0, 1)) missing.greatest = greatest;
  if (missing.least && missing.greatest && *missing.least > *missing.greatest) {
    std::swap(missing.least, missing.greatest);  // a negative slope
  }
  return missing;
}

void remove_missing(const MissingNumbers& missing, OpenVolume& volume) {
  if (missing.values.empty() && !missing.least && !missing.greatest) return;
  const VolumeHeader header = volume.source->header();
  std::vector<std::string> parts;
  if (!missing.values.empty()) {
    std::vector<double> values;
    for (const double stored : missing.values) values.push_back(header.value(stored));
    parts.push_back(fmt::format("of the value{} {:.10g}", values.size() > 1 ? "s" : "",
                                fmt::join(values, " and ")));
  }
  const auto add = [&](const std::optional<double>& limit, bool is_least) {
    if (!limit) return;
    parts.push_back(fmt::format("{} {:.10g}", is_least == (header.slope > 0) ? "below" : "above",
                                header.value(*limit)));
  };
  add(missing.least, true);
  add(missing.greatest, false);
  volume.notes.push_back(fmt::format(
      "voxels {} have no value according to the file's header; --missing-value none keeps them",
      fmt::join(parts, ", or ")));
  volume.source = std::make_unique<MissingSource>(std::move(volume.source), missing);
}

}  // namespace isosplat::import
