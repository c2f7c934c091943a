#include "shared/import/axes/volume_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/geometry/conventions.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {
namespace {

class Reader {
 public:
  Reader(const NamedArray& array, ArrayDescription description, const ImportOptions& options)
      : array_(array), description_(std::move(description)), options_(options) {}

  Result<VolumeAxes> read() {
    notes_ = std::move(description_.notes);
    if (array_.has_other_attributes) {
      notes_.push_back(
          fmt::format("{} has attributes that are not read: a spacing among them has to "
                      "be given with --spacing",
                      printable(array_.name)));
    }
    if (auto picked = pick(); !picked) return tl::unexpected(picked.error());
    name_axes();
    VolumeAxes result;
    result.part = std::move(part_);
    result.geometry = place();
    result.notes = std::move(notes_);
    return result;
  }

 private:
  ArrayAxis& axis(size_t i) { return description_.axes[part_.axes[i]]; }

  /// Chooses the three axes of the volume, and an element along each of the others.
  Result<void> pick() {
    auto& axes = description_.axes;
    part_.at.assign(axes.size(), 0);
    bool has_time = false, has_channel = false;
    std::vector<size_t> picked;
    for (size_t i = 0; i < axes.size(); ++i) {
      if (axes[i].size < 2) continue;
      if (axes[i].letter == 't' || axes[i].letter == 'c') {
        bool& has = axes[i].letter == 't' ? has_time : has_channel;
        if (has) return too_many();
        has = true;
        const auto chosen = axes[i].letter == 't'
                                ? choose_step(array_.file, static_cast<int64_t>(axes[i].size),
                                              options_, axes[i].times)
                                : choose_channel(axes[i]);
        if (!chosen) return tl::unexpected(chosen.error());
        part_.at[i] = *chosen;
      } else {
        picked.push_back(i);
      }
    }
    if (picked.size() != 3) return too_many();
    if (!has_time) {
      if (const auto step = choose_step(array_.file, 1, options_); !step) {
        return tl::unexpected(step.error());
      }
    }
    if (!has_channel) {
      if (const auto channel = choose_channel({}); !channel) return tl::unexpected(channel.error());
    }
    for (size_t i = 0; i < 3; ++i) {
      part_.axes[i] = picked[i];
      part_.sizes[i] = axes[picked[i]].size;
    }
    return {};
  }

  Result<uint64_t> choose_channel(const ArrayAxis& channels) const {
    const std::string which =
        fmt::format("{} in {}", channels.name.empty() ? "" : " (" + printable(channels.name) + ")",
                    printable(array_.name));
    return import::choose_channel(array_.file, std::max<uint64_t>(channels.size, 1), options_, {},
                                  which);
  }

  tl::unexpected<Error> too_many() const {
    std::string list;
    for (const ArrayAxis& axis : description_.axes) {
      if (axis.size < 2) continue;
      if (!list.empty()) list += ", ";
      list += axis.name.empty() ? fmt::format("{}", axis.size)
                                : fmt::format("{} ({})", printable(axis.name), axis.size);
    }
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected an array with the axes z, y and x, found axes of {} in {}: "
                    "{}",
                    array_.file.string(), list, printable(array_.name), array_.advice));
  }

  /// Assigns a different letter to each axis.
  void name_axes() {
    std::string known, names;
    bool has_names = false;
    for (size_t i = 0; i < 3; ++i) {
      if (axis(i).letter != 0) known += axis(i).letter;
      has_names = has_names || !axis(i).name.empty();
      names += fmt::format("{}'{}'",
                           i == 0   ? ""
                           : i == 1 ? ", "
                                    : " and ",
                           printable(axis(i).name));
    }
    std::string sorted = known;
    std::sort(sorted.begin(), sorted.end());
    const bool is_twice = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    if (sorted.size() == 3 && !is_twice) return;
    if (is_twice) known.clear();
    std::string free;
    for (const char letter : {'z', 'y', 'x'}) {
      if (known.find(letter) == known.npos) free += letter;
    }
    size_t next = 0;
    std::string read_as;
    for (size_t i = 0; i < 3; ++i) {
      if (is_twice || axis(i).letter == 0) axis(i).letter = free[next++];
      read_as += fmt::format("{}{}", i == 0 ? "" : i == 1 ? ", " : " and ", axis(i).letter);
    }
    notes_.push_back(has_names ? fmt::format("the axes of {} are named {}: they are read as {}",
                                             printable(array_.name), names, read_as)
                               : fmt::format("the {} file does not name the array's axes: they are "
                                             "read as z, y and x, the last one as x",
                                             array_.format));
  }

  HeaderGeometry place() {
    std::array<Vec3d, 3> steps;
    Vec3d origin = description_.origin;
    std::string missing;
    for (size_t i = 0; i < 3; ++i) {
      ArrayAxis& each = axis(i);
      if (each.is_downwards && each.step && each.letter == 'z') {
        each.step = -*each.step;
        each.first = -each.first;
        notes_.push_back(fmt::format("the positions along {} are depths: z is their negative",
                                     printable(each.name)));
      }
      if (!each.step) missing += each.letter;
      double step = each.step.value_or(1);
      const size_t letter = static_cast<size_t>(each.letter - 'x');
      if (options_.spacing) {
        const Vec3d& given = *options_.spacing;
        step = std::copysign(letter == 0 ? given.x : letter == 1 ? given.y : given.z, step);
      }
      // The array's fastest axis is the first one of a geometry.
      steps[2 - i] = description_.directions[letter] * step;
      origin = origin + description_.directions[letter] * each.first;
    }
    if (missing.size() == 3 && !options_.spacing) {
      notes_.push_back(
          fmt::format("no voxel spacing was found in the {} file: 1,1,1 is assumed; "
                      "--spacing sets another",
                      array_.format));
    } else if (!missing.empty() && !options_.spacing) {
      std::sort(missing.begin(), missing.end());
      notes_.push_back(
          fmt::format("no voxel spacing along {} was found in the {} file: 1 is assumed; "
                      "--spacing sets another",
                      fmt::join(missing, " and "), array_.format));
    }
    return geometry_of_steps(steps, origin);
  }

  const NamedArray& array_;
  ArrayDescription description_;
  const ImportOptions& options_;
  ArrayPart part_;
  std::vector<std::string> notes_;
};

}  // namespace

Result<VolumeAxes> volume_axes(const NamedArray& array, ArrayDescription description,
                               const ImportOptions& options) {
  return Reader(array, std::move(description), options).read();
}

}  // namespace isosplat::import
