#include "shared/import/voxels/missing_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/voxels/absent_voxels.h"
#include "shared/import/voxels/value_sample.h"

namespace isosplat::import {
namespace {

class MissingSource : public VolumeSource {
 public:
  MissingSource(std::unique_ptr<VolumeSource> source, const FillValue& missing)
      : source_(std::move(source)), missing_(missing), header_(source_->header()) {
    header_.type = type_with_absent(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return read_rows({first, count, 0, header_.grid.voxels.y}, out);
  }

  bool reads_rows() const override { return source_->reads_rows(); }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
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
    if (auto read = source_->read_rows(part, in); !read) return read;
    if (type != header_.type) convert_voxels(type, in, header_.type, out);
    header_.type == VoxelType::f32 ? remove_missing<float>(out) : remove_missing<double>(out);
    return {};
  }

  uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return source_->files(); }

 private:
  template <class T>
  void remove_missing(std::span<std::byte> voxels) const {
    const VolumeHeader& header = source_->header();
    for (; !voxels.empty(); voxels = voxels.subspan(sizeof(T))) {
      T voxel;
      std::memcpy(&voxel, voxels.data(), sizeof(T));
      if (!has_fill_value(header, static_cast<double>(voxel), missing_)) continue;
      voxel = std::numeric_limits<T>::quiet_NaN();
      std::memcpy(voxels.data(), &voxel, sizeof(T));
    }
  }

  std::unique_ptr<VolumeSource> source_;
  FillValue missing_;
  VolumeHeader header_;
  std::vector<std::byte> scratch_;
};

/// Whether the distance of a fill value to all other values exceeds 1/50 of their range.
bool lies_apart(const FillValue& fill, const ValueSample& sample) {
  const double low = sample.low.value, high = -sample.high.value;
  const double gap = std::max(low - fill.high, fill.low - high);
  return sample.count > 0 && gap > 0.02 * (high - low);
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

/// Applies the fill value of the file's header.
OpenVolume with_declared(OpenVolume volume, const FillValue& fill, const ValueSample& sample) {
  if (fill.is_certain || (lies_apart(fill, sample) && !sample.is_label_map)) {
    return without(std::move(volume), fill,
                   " have no value according to the file's header; --missing-value none keeps "
                   "them");
  }
  volume.notes.push_back(fmt::format(
      "according to the file's header, voxels of the {} are padding: they are kept, since {}; "
      "--missing-value={:.10g} removes them",
      text_of(fill),
      sample.is_label_map ? "they are the background of labels"
                          : "other voxels have similar values",
      fill.low));
  return volume;
}

/// The role of a value that is kept, for notes.
const char* role_of(OutlyingValue::Place place) {
  switch (place) {
    case OutlyingValue::Place::objects:
      return "it fills compact regions and is kept as the value of objects";
    case OutlyingValue::Place::around:
      return "it fills the border of the volume and is kept as the background";
    case OutlyingValue::Place::scattered:
      break;
  }
  return "it is kept";
}

/// Applies a fill value that was detected in the voxels, or notes the role of an outlying value.
OpenVolume with_outlying(OpenVolume volume, const ValueSample& sample) {
  const auto found = outlying_value(sample, volume.source->header().type);
  if (!found) return volume;
  const double value = found->value;
  if (found->is_fill) {
    return without(
        std::move(volume), {value, value},
        ", far outside the range of all others, have no value; --missing-value none keeps them");
  }
  volume.notes.push_back(
      fmt::format("the value {:.10g} lies far outside the range of all others: {}; if it stands "
                  "for \"no value\", use --missing-value={:.10g}",
                  value, role_of(found->place), value));
  return volume;
}

}  // namespace

Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options) {
  const VolumeHeader& header = volume.source->header();
  if (options.missing_value) {
    const double value = *options.missing_value;
    return without(std::move(volume), {value, value},
                   " have no value, as --missing-value requests");
  }
  if (!options.finds_missing_values) return volume;
  auto declared = volume.fill_value;
  if (declared && !can_have(header, *declared)) declared.reset();
  const bool is_byte = voxel_bytes(header.type) == 1;  // 0 and 255 are ordinary values
  if (is_byte && !declared) return volume;
  const auto sample = sample_values(*volume.source, declared);
  if (!sample) return tl::unexpected(sample.error());
  if (declared && sample->filled > 0) {
    return with_declared(std::move(volume), *declared, *sample);
  }
  // Slices outside the sample may have the header's value.
  if (declared && declared->is_certain && !sample->is_whole) {
    volume = with_declared(std::move(volume), *declared, *sample);
  }
  return is_byte ? std::move(volume) : with_outlying(std::move(volume), *sample);
}

}  // namespace isosplat::import
