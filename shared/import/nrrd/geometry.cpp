#include "shared/import/nrrd/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

std::optional<NrrdSpace> space_named(const std::string& name) {
  struct Known {
    const char *name, *short_name;
    NrrdSpace space;
  };
  static const Known kSpaces[] = {
      {"right-anterior-superior", "ras", {3, Frame::ras}},
      {"left-anterior-superior", "las", {3, Frame::las}},
      {"left-posterior-superior", "lps", {3, Frame::lps}},
      {"right-anterior-superior-time", "rast", {4, Frame::ras}},
      {"left-anterior-superior-time", "last", {4, Frame::las}},
      {"left-posterior-superior-time", "lpst", {4, Frame::lps}},
      {"scanner-xyz", "", {3, Frame::lps}},
      {"scanner-xyz-time", "", {4, Frame::lps}},
      {"3d-right-handed", "", {3, Frame::lps}},
      {"3d-left-handed", "", {3, Frame::left_handed}},
      {"3d-right-handed-time", "", {4, Frame::lps}},
      {"3d-left-handed-time", "", {4, Frame::left_handed}},
  };
  for (const Known& known : kSpaces) {
    if (name == known.name || (*known.short_name && name == known.short_name)) return known.space;
  }
  return std::nullopt;
}

/// "space origin"; 0, 0, 0 if the header has none.
Result<Vec3d> origin_in_space(const std::filesystem::path& path, const NrrdHeader& header,
                              NrrdSpace space, std::vector<std::string>& notes) {
  const auto text = header.field("spaceorigin");
  if (text.empty()) return Vec3d{0, 0, 0};
  const auto parts = split_vectors(text);
  const auto vector = parts.size() == 1 ? parse_vector(parts[0]) : std::nullopt;
  if (!vector || vector->size() != (space.dimension == 0 ? 3 : space.dimension)) {
    return malformed_nrrd(
        path, fmt::format("expected a space origin of three numbers, found '{}'", text));
  }
  const Vec3d origin{(*vector)[0], (*vector)[1], (*vector)[2]};
  if (!std::isfinite(origin.x) || !std::isfinite(origin.y) || !std::isfinite(origin.z)) {
    notes.push_back("the header has no space origin: the first voxel is placed at 0, 0, 0");
    return Vec3d{0, 0, 0};
  }
  return origin;
}

/// The geometry from "space directions", in millimetres and in the axes of the space.
Result<HeaderGeometry> geometry_in_space(const std::filesystem::path& path,
                                         const NrrdHeader& header,
                                         const std::vector<NrrdAxis>& axes,
                                         std::span<const size_t, 3> spatial, NrrdSpace space,
                                         std::vector<std::string>& notes) {
  std::array<Vec3d, 3> steps;
  for (size_t i = 0; i < 3; ++i) {
    const auto& d = *axes[spatial[i]].direction;
    const bool fits = d.size() == (space.dimension == 0 ? 3 : space.dimension) &&
                      (d.size() == 3 || (d.size() == 4 && d[3] == 0));
    if (!fits) {
      return malformed_nrrd(path,
                            fmt::format("expected a space direction of three numbers for axis {}, "
                                        "found '{}'",
                                        spatial[i] + 1, header.field("spacedirections")));
    }
    steps[i] = {d[0], d[1], d[2]};
    const double spacing = axes[spatial[i]].spacing, distance = length(steps[i]);
    if (std::isfinite(spacing) && std::abs(std::abs(spacing) - distance) > 1e-3 * distance) {
      return malformed_nrrd(
          path, fmt::format("axis {} has the spacing {}, but a space direction of length {}: one "
                            "of 'spacings' and 'space directions' is wrong",
                            spatial[i] + 1, spacing, distance));
    }
  }
  const auto origin = origin_in_space(path, header, space, notes);
  if (!origin) return tl::unexpected(origin.error());
  HeaderGeometry geometry = geometry_of_steps(steps, *origin);
  const auto units = quoted_strings(header.field("spaceunits"));
  if (!units) return malformed_nrrd(path, "the quotes of 'space units' do not match");
  const size_t dimension = space.dimension == 0 ? 3 : space.dimension;
  if (!header.field("spaceunits").empty()) {
    if (units->size() != dimension) {
      return malformed_nrrd(path, fmt::format("expected {} units in quotes in 'space units', found "
                                              "'{}'",
                                              dimension, header.field("spaceunits")));
    }
    if ((*units)[0] != (*units)[1] || (*units)[0] != (*units)[2]) {
      return malformed_nrrd(path, "expected the same unit for x, y and z in 'space units'");
    }
    to_millimetres((*units)[0], geometry, notes);
  }
  return geometry;
}

/// The position of the first sample of an axis without a space, and the step to the next sample.
struct Line {
  double first = 0, step = 1;
};

/// `has_spacings`: the header has the field "spacings". A spacing that is not a number is kept, so
/// that orient adds its note.
Line line_of(const NrrdAxis& axis, size_t index, bool has_spacings,
             std::vector<std::string>& notes) {
  const bool has_spacing = std::isfinite(axis.spacing) && axis.spacing != 0;
  const bool has_min = std::isfinite(axis.min), has_max = std::isfinite(axis.max);
  Line line;
  if (has_spacings) line.step = axis.spacing;
  if (!has_min && !has_max) return line;
  const bool cell = axis.center == "cell";
  if (!cell && axis.center != "node") {
    notes.push_back(
        fmt::format("axis {}: 'axis mins' and 'axis maxs' are assumed to be the first and last "
                    "sample (center: node), since the header has no 'centers'",
                    index + 1));
  }
  const auto size = static_cast<double>(axis.size);
  if (has_min && has_max) {
    const double step =
        cell ? (axis.max - axis.min) / size : (axis.max - axis.min) / std::max(1.0, size - 1);
    if (!has_spacing) {
      line.step = step;
    } else if (std::abs(step - axis.spacing) > 1e-3 * std::abs(axis.spacing)) {
      notes.push_back(fmt::format(
          "axis {}: spacing {} does not fit its mins and maxs ({}): the spacing is used", index + 1,
          axis.spacing, step));
    }
  }
  if (has_min) {
    line.first = axis.min + (cell ? line.step / 2 : 0);
  } else {
    line.first = axis.max - (cell ? line.step * (size - 0.5) : line.step * (size - 1));
  }
  return line;
}

/// The geometry from spacings, mins, maxs and units of the axes, in millimetres: the axes are
/// parallel to x, y and z.
Result<HeaderGeometry> geometry_without_space(const std::filesystem::path& path,
                                              const NrrdHeader& header,
                                              const std::vector<NrrdAxis>& axes,
                                              std::span<const size_t, 3> spatial,
                                              std::vector<std::string>& notes) {
  Line lines[3];
  const bool has_spacings = !header.field("spacings").empty();
  if (!has_spacings && header.field("axismins").empty() && header.field("axismaxs").empty()) {
    notes.push_back(
        "the header has no voxel spacing: 1,1,1 is assumed; --spacing sets "
        "another");
  }
  for (size_t i = 0; i < 3; ++i) {
    lines[i] = line_of(axes[spatial[i]], spatial[i], has_spacings, notes);
    if (const auto& unit = axes[spatial[i]].unit; !unit.empty()) {
      if (const auto factor = millimetres_in(unit)) {
        lines[i] = {lines[i].first * *factor, lines[i].step * *factor};
      } else {
        notes.push_back(fmt::format("axis {}: its unit '{}' is unknown: millimetres are assumed",
                                    spatial[i] + 1, unit));
      }
    }
    if (lines[i].step < 0) {
      notes.push_back(fmt::format("axis {}: its spacing {} is negative: the axis is reversed",
                                  spatial[i] + 1, lines[i].step));
    }
  }
  Vec3d origin{lines[0].first, lines[1].first, lines[2].first};
  if (const auto text = header.field("spaceorigin"); !text.empty()) {
    const auto parts = split_vectors(text);
    const auto vector = parts.size() == 1 ? parse_vector(parts[0]) : std::nullopt;
    if (!vector || vector->size() < 3) {
      return malformed_nrrd(
          path, fmt::format("expected a space origin of three numbers, found '{}'", text));
    }
    origin = {(*vector)[0], (*vector)[1], (*vector)[2]};
  }
  return geometry_of_spacing({lines[0].step, lines[1].step, lines[2].step}, origin);
}

}  // namespace

Result<NrrdSpace> read_nrrd_space(const std::filesystem::path& path, const NrrdHeader& header) {
  NrrdSpace space;
  const std::string name = lower_case(header.field("space"));
  if (!name.empty()) {
    const auto named = space_named(name);
    if (!named) {
      return malformed_nrrd(path,
                            fmt::format("expected a space such as left-posterior-superior, found "
                                        "'{}'",
                                        name));
    }
    return *named;
  }
  if (const auto text = header.field("spacedimension"); !text.empty()) {
    const auto dimension = whole_number(text);
    if (!dimension || (*dimension != 3 && *dimension != 4)) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected a space of three dimensions, found '{}': save the "
                              "volume in three dimensions",
                              path.string(), text));
    }
    space.dimension = static_cast<size_t>(*dimension);
  }
  return space;
}

Result<HeaderGeometry> nrrd_geometry(const std::filesystem::path& path, const NrrdHeader& header,
                                     const std::vector<NrrdAxis>& axes,
                                     std::span<const size_t, 3> spatial, const NrrdSpace& space,
                                     std::vector<std::string>& notes) {
  auto geometry = axes[spatial[0]].direction
                      ? geometry_in_space(path, header, axes, spatial, space, notes)
                      : geometry_without_space(path, header, axes, spatial, notes);
  if (!geometry) return geometry;
  if (!axes[spatial[0]].direction && !header.field("space").empty()) {
    notes.push_back(
        fmt::format("the header has no space directions: the axes are assumed to be those of its "
                    "space, {}",
                    header.field("space")));
  }
  to_lps(space.frame, *geometry);
  if (space.frame == Frame::left_handed) {
    notes.push_back("the header's space is left-handed: z is negated, so that nothing is mirrored");
  }
  return geometry;
}

}  // namespace isosplat::import
