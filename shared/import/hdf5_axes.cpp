#include "shared/import/hdf5_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/import/conventions.h"
#include "shared/import/hdf5_array.h"
#include "shared/import/hdf5_attributes.h"
#include "shared/import/header_text.h"

namespace isosplat {
namespace {

using Names = std::vector<std::string>;

/// The keys of vigra's text {"axes": [{"key": "z", …}, …]}; none if it has another number of axes.
Names tagged_axes(std::string_view text, size_t axes) {
  constexpr std::string_view kKey = "\"key\"";
  Names names;
  for (size_t at = text.find(kKey); at != text.npos; at = text.find(kKey, at + 1)) {
    const size_t colon = text.find_first_not_of(" \n\t", at + kKey.size());
    if (colon == text.npos || text[colon] != ':') return {};
    const size_t begin = text.find_first_not_of(" \n\t", colon + 1);
    if (begin == text.npos || text[begin] != '"') return {};
    const size_t end = text.find('"', begin + 1);
    if (end == text.npos) return {};
    names.emplace_back(text.substr(begin + 1, end - begin - 1));
  }
  return names.size() == axes ? names : Names{};
}

/// The positions along an axis: a dataset with one axis of this size.
Result<std::optional<std::vector<double>>> positions_at(const std::shared_ptr<Hdf5File>& file,
                                                        const Hdf5Object& object, uint64_t size) {
  constexpr uint64_t kMaxPositions = uint64_t{1} << 20;
  if (!object.find(Hdf5Kind::layout) || size > kMaxPositions) return std::nullopt;
  const auto elements = hdf5_elements(*file, object);
  if (!elements) return tl::unexpected(elements.error());
  const auto& [sizes, type] = *elements;
  if (!sizes || !type || type->kind != Hdf5Type::Kind::number || sizes->size() != 1 ||
      sizes->front() != size) {
    return std::nullopt;
  }
  auto layout = read_hdf5_layout(*file, object, *sizes, type->bytes);
  if (!layout) return tl::unexpected(layout.error());
  const auto bytes = static_cast<size_t>(type->bytes);
  std::vector<std::byte> raw;
  if (layout->index == Hdf5Layout::Index::none) {
    auto read = file->read(layout->address, size * bytes);
    if (!read) return tl::unexpected(read.error());
    raw = std::move(*read);
  } else {
    auto array = open_hdf5_array(file, std::move(*layout));
    if (!array) return tl::unexpected(array.error());
    raw.resize(static_cast<size_t>(size) * bytes);
    if (auto read = (*array)->read(0, raw); !read) return tl::unexpected(read.error());
  }
  std::vector<double> positions;
  for (size_t i = 0; i < size; ++i) {
    positions.push_back(hdf5_number(type->stored, std::span(raw).subspan(i * bytes, bytes)));
  }
  return positions;
}

struct Step {
  double origin = 0, spacing = 1;
};

/// First position and distance of evenly spaced positions; nothing if they are not.
std::optional<Step> step_of(const std::vector<double>& positions) {
  const double first = positions.front();
  const double step = (positions.back() - first) / static_cast<double>(positions.size() - 1);
  if (!std::isfinite(first) || !std::isfinite(step) || step == 0) return std::nullopt;
  for (size_t i = 0; i < positions.size(); ++i) {
    const double expected = first + static_cast<double>(i) * step;
    // Positions are often 32-bit floats.
    if (!(std::abs(positions[i] - expected) <= 0.01 * std::abs(step))) return std::nullopt;
  }
  return Step{first, step};
}

class Reader {
 public:
  Reader(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
         const ImportOptions& options)
      : file_(file), volume_(volume), options_(options) {}

  Result<Hdf5Axes> read() {
    size_t to = 0;
    for (size_t i = 0; i < volume_.sizes.size(); ++i) {
      if (volume_.sizes[i] < 2) continue;
      picked_[to] = i;
      axes_.sizes[to++] = volume_.sizes[i];
    }
    if (hdf5_has_other_attributes(*file_, volume_.object)) {
      axes_.notes.push_back(
          fmt::format("{} has attributes that are not read: a spacing among them "
                      "has to be given with --spacing",
                      hdf5_printable(volume_.path)));
    }
    if (auto named = name_axes(); !named) return tl::unexpected(named.error());
    if (auto placed = place(); !placed) return tl::unexpected(placed.error());
    std::array<Vec3d, 3> steps;
    Vec3d origin{0, 0, 0};
    for (size_t i = 0; i < 3; ++i) {
      // The array's fastest axis is the first one of a geometry.
      Vec3d& step = steps[2 - i];
      step = {0, 0, 0};
      (labels_[i] == 'x' ? step.x : labels_[i] == 'y' ? step.y : step.z) = steps_[i].spacing;
      (labels_[i] == 'x' ? origin.x : labels_[i] == 'y' ? origin.y : origin.z) = steps_[i].origin;
    }
    axes_.geometry = geometry_of_steps(steps, origin);
    return std::move(axes_);
  }

 private:
  Result<void> name_axes() {
    const size_t count = volume_.sizes.size();
    if (const auto tags = hdf5_texts(*file_, volume_.object, "axistags");
        tags && tags->size() == 1) {
      names_ = tagged_axes(tags->front(), count);
    }
    const auto parent = hdf5_object_at(*file_, volume_.parent);
    if (!parent) return tl::unexpected(parent.error());
    if (*parent) {
      group_ = **parent;
      const auto signal = hdf5_texts(*file_, group_, "signal");
      const auto axes = hdf5_texts(*file_, group_, "axes");
      // A group has positions for its signal alone.
      if (signal && signal->size() == 1 && volume_.path == volume_.parent + "/" + signal->front() &&
          axes && axes->size() == count) {
        positions_ = *axes;
      }
    }
    if (names_.empty()) names_ = positions_;
    std::string letters;
    for (const size_t i : picked_) {
      const std::string name = names_.empty() ? "" : lower_case(names_[i]);
      if (name == "c" || name == "t" || name == "channel" || name == "time") {
        return fail(
            Status::unsupported_format,
            fmt::format("{}: expected the axes z, y and x, found the axis {} with {} samples "
                        "in {}: save one of them as a volume of its own",
                        file_->path().string(), name, volume_.sizes[i],
                        hdf5_printable(volume_.path)));
      }
      letters += name.size() == 1 ? name : "?";
    }
    std::string sorted = letters;
    std::sort(sorted.begin(), sorted.end());
    if (sorted == "xyz") {
      labels_ = letters;
    } else {
      axes_.notes.push_back(
          "the HDF5 file does not name the array's axes: they are read as z, y and x, the last one "
          "as x");
    }
    return {};
  }

  Result<void> place() {
    if (options_.spacing) {
      for (size_t i = 0; i < 3; ++i) {
        const Vec3d& given = *options_.spacing;
        steps_[i].spacing = labels_[i] == 'x' ? given.x : labels_[i] == 'y' ? given.y : given.z;
      }
      return {};
    }
    const auto sizes = hdf5_numbers(*file_, volume_.object, "element_size_um");
    if (sizes && (sizes->size() == 3 || sizes->size() == volume_.sizes.size())) {
      for (size_t i = 0; i < 3; ++i) {
        const double size = (*sizes)[sizes->size() == 3 ? i : picked_[i]];
        steps_[i].spacing = size * *millimetres_in("um");
      }
      return {};
    }
    bool has_any = false;
    for (size_t i = 0; i < 3 && !positions_.empty(); ++i) {
      const std::string& name = positions_[picked_[i]];
      const auto object = hdf5_object_at(*file_, volume_.parent + "/" + name);
      if (!object) return tl::unexpected(object.error());
      if (name.empty() || name == "." || !*object) continue;
      const auto positions = positions_at(file_, **object, axes_.sizes[i]);
      if (!positions) return tl::unexpected(positions.error());
      if (!*positions) continue;
      const auto step = step_of(**positions);
      if (!step) {
        return fail(Status::unsupported_format,
                    fmt::format("{}: expected evenly spaced positions along the axis {}, found "
                                "others: resample the volume, or give --spacing",
                                file_->path().string(), hdf5_printable(name)));
      }
      has_any = true;
      const double unit = unit_of(**object, name);
      steps_[i] = {step->origin * unit, step->spacing * unit};
    }
    if (!has_any) {
      axes_.notes.push_back(
          "the HDF5 file has no voxel spacing: 1,1,1 is assumed; --spacing sets another");
    }
    return {};
  }

  /// In mm.
  double unit_of(const Hdf5Object& axis, const std::string& name) {
    const auto texts = hdf5_texts(*file_, axis, "units");
    const std::string unit = texts && texts->size() == 1 ? texts->front() : "";
    const auto known = millimetres_in(unit);
    if (!known) {
      axes_.notes.push_back(
          unit.empty() ? fmt::format("the axis {} has no unit: mm is assumed", hdf5_printable(name))
                       : fmt::format("the unit '{}' of the axis {} is not known: mm is assumed",
                                     hdf5_printable(unit), hdf5_printable(name)));
    }
    return known.value_or(1);
  }

  const std::shared_ptr<Hdf5File>& file_;
  const Hdf5Volume& volume_;
  const ImportOptions& options_;
  Hdf5Axes axes_;
  std::array<size_t, 3> picked_{};  ///< of all axes, those with several voxels
  Names names_;                     ///< of all axes; empty: unknown
  Names positions_;                 ///< of all axes, the datasets with their positions; or empty
  Hdf5Object group_;                ///< that the volume is in
  std::string labels_ = "zyx";      ///< of those picked
  std::array<Step, 3> steps_{};     ///< of those picked, in mm
};

}  // namespace

Result<Hdf5Axes> hdf5_axes(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                           const ImportOptions& options) {
  return Reader(file, volume, options).read();
}

}  // namespace isosplat
