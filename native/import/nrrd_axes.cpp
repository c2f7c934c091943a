#include "native/import/nrrd_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "native/import/conventions.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"

namespace isosplat {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// One axis, from the header's per-axis fields.
struct Axis {
  int64_t size = 0;
  std::string kind;
  double spacing = kNone, min = kNone, max = kNone;
  std::string center, unit;
  std::optional<std::vector<double>> direction;
  bool is_none = false;  ///< its entry in "space directions" is "none"
};

/// The dimension of a space and its frame.
struct Space {
  size_t dimension = 0;  ///< 0: the header has no space
  Frame frame = Frame::lps;
};

std::optional<Space> space_named(const std::string& name) {
  struct Known {
    const char *name, *short_name;
    Space space;
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

/// Parses "(1,0,0)". Nothing if the text is not a vector.
std::optional<std::vector<double>> parse_vector(std::string_view text) {
  if (!text.starts_with('(') || !text.ends_with(')')) return std::nullopt;
  text = text.substr(1, text.size() - 2);
  std::vector<double> numbers;
  for (;;) {
    const size_t comma = std::min(text.find(','), text.size());
    const auto number = number_in(trimmed(text.substr(0, comma)));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (comma == text.size()) return numbers;
    text.remove_prefix(comma + 1);
  }
}

/// Splits "space directions" or "space origin" into vectors and "none"s. White space is allowed
/// inside parentheses.
std::vector<std::string> vector_texts(std::string_view text) {
  std::vector<std::string> all;
  while (!(text = trimmed(text)).empty()) {
    size_t end = text.starts_with('(') ? text.find(')') : text.find_first_of(" \t(");
    if (end == text.npos) end = text.size();
    if (text.starts_with('(') && end < text.size()) ++end;
    all.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return all;
}

/// Whether an axis holds the components of one voxel, by the kinds in the specification.
bool is_component_kind(const std::string& kind) {
  return kind == "vector" || kind == "covariant-vector" || kind == "normal" || kind == "complex" ||
         kind == "stub" || kind == "scalar" || kind == "quaternion" || kind == "point" ||
         kind.ends_with("-color") || kind.find("-vector") != kind.npos ||
         kind.find("-normal") != kind.npos || kind.find("-gradient") != kind.npos ||
         kind.find("matrix") != kind.npos;
}

bool is_space_kind(const std::string& kind) {
  return kind == "domain" || kind == "space";
}

bool is_unspecified_kind(const std::string& kind) {
  return kind.empty() || kind == "???" || kind == "none" || kind == "unknown";
}

/// Parses a per-axis field into a member of each axis. False if the number of values differs.
bool read_numbers(std::string_view text, std::vector<Axis>& axes, double Axis::*member) {
  if (text.empty()) return true;
  const auto parts = words(text);
  if (parts.size() != axes.size()) return false;
  for (size_t i = 0; i < parts.size(); ++i) {
    const auto number = number_in(parts[i]);
    if (!number) return false;
    axes[i].*member = *number;
  }
  return true;
}

Result<std::vector<Axis>> read_axes(const std::filesystem::path& path, const NrrdHeader& header) {
  const auto sizes = whole_numbers(header.field("sizes"));
  const auto dimension = whole_number(header.field("dimension"));
  if (!sizes || sizes->empty() || sizes->size() > 16 || !dimension ||
      *dimension != static_cast<int64_t>(sizes->size()) || std::ranges::min(*sizes) < 1) {
    return malformed_nrrd(path, fmt::format("expected as many sizes above 0 as dimensions, found "
                                            "dimension '{}' and sizes '{}'",
                                            header.field("dimension"), header.field("sizes")));
  }
  std::vector<Axis> axes(sizes->size());
  for (size_t i = 0; i < axes.size(); ++i) axes[i].size = (*sizes)[i];
  const auto wrong = [&](const char* name) {
    return malformed_nrrd(path, fmt::format("expected one of '{}' for each of {} axes, found '{}'",
                                            name, axes.size(), header.field(name)));
  };
  if (!read_numbers(header.field("spacings"), axes, &Axis::spacing)) return wrong("spacings");
  if (!read_numbers(header.field("axismins"), axes, &Axis::min)) return wrong("axismins");
  if (!read_numbers(header.field("axismaxs"), axes, &Axis::max)) return wrong("axismaxs");
  const auto read_words = [&](const char* name, std::string Axis::*member) {
    const auto parts = words(header.field(name));
    if (!parts.empty() && parts.size() != axes.size()) return false;
    for (size_t i = 0; i < parts.size(); ++i) axes[i].*member = lower_case(parts[i]);
    return true;
  };
  if (!read_words("kinds", &Axis::kind)) return wrong("kinds");
  if (!read_words("centers", &Axis::center)) return wrong("centers");
  if (!header.field("units").empty()) {
    const auto units = quoted_strings(header.field("units"));
    if (!units || units->size() != axes.size()) return wrong("units");
    for (size_t i = 0; i < axes.size(); ++i) axes[i].unit = (*units)[i];
  }
  const auto vectors = vector_texts(header.field("spacedirections"));
  if (!vectors.empty() && vectors.size() != axes.size()) return wrong("spacedirections");
  for (size_t i = 0; i < vectors.size(); ++i) {
    axes[i].is_none = lower_case(vectors[i]) == "none";
    if (axes[i].is_none) continue;
    axes[i].direction = parse_vector(vectors[i]);
    if (!axes[i].direction) return wrong("spacedirections");
  }
  return axes;
}

/// Finds the spatial axes, in file order.
std::vector<size_t> find_spatial_axes(const std::vector<Axis>& axes,
                                      std::vector<std::string>& notes) {
  std::vector<size_t> found;
  const auto collect = [&](auto&& is_one) {
    found.clear();
    for (size_t i = 0; i < axes.size(); ++i) {
      if (is_one(axes[i])) found.push_back(i);
    }
    return found.size();
  };
  if (std::ranges::any_of(axes, [](const Axis& a) { return a.direction || a.is_none; })) {
    collect([](const Axis& a) { return a.direction.has_value(); });
    return found;
  }
  if (std::ranges::any_of(axes, [](const Axis& a) { return !is_unspecified_kind(a.kind); })) {
    // If there are too few spatial axes, axes without any declaration are spatial.
    if (collect([](const Axis& a) { return is_space_kind(a.kind); }) < 3) {
      collect([](const Axis& a) { return is_space_kind(a.kind) || is_unspecified_kind(a.kind); });
    }
    return found;
  }
  // A spacing of "nan" marks an axis without spacing; beside axes with spacings it is not spatial.
  if (collect([](const Axis& a) { return std::isfinite(a.spacing) && a.spacing != 0; }) == 3) {
    return found;
  }
  collect([](const Axis&) { return true; });
  if (found.size() > 3) {
    notes.push_back("the header does not mark its spatial axes: the first three are assumed");
    found.resize(3);
  } else if (found.size() == 3 && axes[0].size <= 4) {
    notes.push_back(
        fmt::format("the header does not mark its spatial axes: the first, with {} samples, is "
                    "assumed to be one; if it holds colours, save one channel as a separate volume",
                    axes[0].size));
  }
  return found;
}

/// The position of the first sample of an axis without a space, and the step to the next sample.
struct Line {
  double first = 0, step = 1;
};

/// `has_spacings`: the header has the field "spacings". A spacing that is not a number is kept, so
/// that orient adds its note.
Line line_of(const Axis& axis, size_t index, bool has_spacings, std::vector<std::string>& notes) {
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

Result<HeaderGeometry> geometry_in_space(const std::filesystem::path& path,
                                         const NrrdHeader& header, const std::vector<Axis>& axes,
                                         std::span<const size_t> spatial, Space space,
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
  }
  Vec3d origin{0, 0, 0};
  if (const auto text = header.field("spaceorigin"); !text.empty()) {
    const auto parts = vector_texts(text);
    const auto vector = parts.size() == 1 ? parse_vector(parts[0]) : std::nullopt;
    if (!vector || vector->size() != (space.dimension == 0 ? 3 : space.dimension)) {
      return malformed_nrrd(
          path, fmt::format("expected a space origin of three numbers, found '{}'", text));
    }
    origin = {(*vector)[0], (*vector)[1], (*vector)[2]};
    if (!std::isfinite(origin.x) || !std::isfinite(origin.y) || !std::isfinite(origin.z)) {
      notes.push_back("the header has no space origin: the first voxel is placed at 0, 0, 0");
      origin = {0, 0, 0};
    }
  }
  return geometry_of_steps(steps, origin);
}

}  // namespace

Result<NrrdAxes> read_nrrd_axes(const std::filesystem::path& path, const NrrdHeader& header) {
  auto read = read_axes(path, header);
  if (!read) return tl::unexpected(read.error());
  std::vector<Axis>& axes = *read;
  NrrdAxes result;

  Space space;
  const std::string space_name = lower_case(header.field("space"));
  if (!space_name.empty()) {
    const auto named = space_named(space_name);
    if (!named) {
      return malformed_nrrd(path,
                            fmt::format("expected a space such as left-posterior-superior, found "
                                        "'{}'",
                                        space_name));
    }
    space = *named;
  } else if (const auto text = header.field("spacedimension"); !text.empty()) {
    const auto dimension = whole_number(text);
    if (!dimension || (*dimension != 3 && *dimension != 4)) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected a space of three dimensions, found '{}': save the "
                              "volume in three dimensions",
                              path.string(), text));
    }
    space.dimension = static_cast<size_t>(*dimension);
  }
  // In a space with time, an axis along time alone is not spatial.
  for (Axis& axis : axes) {
    if (space.dimension != 4 || !axis.direction || axis.direction->size() != 4) continue;
    const auto& d = *axis.direction;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0 && d[3] != 0) {
      axis.direction.reset();
      axis.is_none = true;
      if (is_unspecified_kind(axis.kind)) axis.kind = "time";
    }
  }

  const std::vector<size_t> spatial = find_spatial_axes(axes, result.notes);
  std::vector<size_t> others;  // axes with more than one sample
  for (size_t i = 0; i < axes.size(); ++i) {
    if (std::ranges::find(spatial, i) == spatial.end() && axes[i].size > 1) others.push_back(i);
  }
  for (const size_t i : others) {
    if (is_component_kind(axes[i].kind)) return not_scalar(path, static_cast<int>(axes[i].size));
  }
  if (spatial.size() != 3) {
    return fail(spatial.size() < 3 ? Status::no_cells : Status::unsupported_format,
                fmt::format("{}: expected a volume with three spatial axes, found an image with "
                            "{}: give the file that contains all slices, or correct 'kinds' and "
                            "'space directions'",
                            path.string(), spatial.size()));
  }
  if (others.size() > 1) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected three spatial axes and one of time, found {} others: "
                            "save one volume as a separate file",
                            path.string(), others.size()));
  }
  result.voxels = {axes[spatial[0]].size, axes[spatial[1]].size, axes[spatial[2]].size};
  if (!others.empty()) {
    result.steps = axes[others[0]].size;
    result.step_axis = static_cast<size_t>(
        std::ranges::count_if(spatial, [&](size_t i) { return i < others[0]; }));
  }

  if (axes[spatial[0]].direction) {
    auto geometry = geometry_in_space(path, header, axes, spatial, space, result.notes);
    if (!geometry) return tl::unexpected(geometry.error());
    result.geometry = *geometry;
    const auto units = quoted_strings(header.field("spaceunits"));
    if (!units) return malformed_nrrd(path, "the quotes of 'space units' do not match");
    if (units->size() >= 3) {
      if ((*units)[0] != (*units)[1] || (*units)[0] != (*units)[2]) {
        return malformed_nrrd(path, "expected the same unit for x, y and z in 'space units'");
      }
      to_millimetres((*units)[0], result.geometry, result.notes);
    }
  } else {
    Line lines[3];
    const bool has_spacings = !header.field("spacings").empty();
    if (!has_spacings && header.field("axismins").empty() && header.field("axismaxs").empty()) {
      result.notes.push_back(
          "the header has no voxel spacing: 1,1,1 is assumed; --spacing sets "
          "another");
    }
    for (size_t i = 0; i < 3; ++i) {
      lines[i] = line_of(axes[spatial[i]], spatial[i], has_spacings, result.notes);
      if (const auto& unit = axes[spatial[i]].unit; !unit.empty()) {
        if (const auto factor = millimetres_in(unit)) {
          lines[i] = {lines[i].first * *factor, lines[i].step * *factor};
        } else {
          result.notes.push_back(fmt::format(
              "axis {}: its unit '{}' is unknown: millimetres are assumed", spatial[i] + 1, unit));
        }
      }
      if (lines[i].step < 0) {
        result.notes.push_back(
            fmt::format("axis {}: its spacing {} is negative: the axis is reversed", spatial[i] + 1,
                        lines[i].step));
      }
    }
    Vec3d origin{lines[0].first, lines[1].first, lines[2].first};
    if (const auto text = header.field("spaceorigin"); !text.empty()) {
      const auto parts = vector_texts(text);
      const auto vector = parts.size() == 1 ? parse_vector(parts[0]) : std::nullopt;
      if (!vector || vector->size() < 3) {
        return malformed_nrrd(
            path, fmt::format("expected a space origin of three numbers, found '{}'", text));
      }
      origin = {(*vector)[0], (*vector)[1], (*vector)[2]};
    }
    result.geometry = geometry_of_spacing({lines[0].step, lines[1].step, lines[2].step}, origin);
  }
  to_lps(space.frame, result.geometry);
  if (space.frame == Frame::left_handed) {
    result.notes.push_back(
        "the header's space is left-handed: z is negated, so that nothing is mirrored");
  }
  return result;
}

}  // namespace isosplat
