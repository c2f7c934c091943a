#include "shared/import/nrrd/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "shared/import/nrrd/geometry.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"

namespace isosplat::import {
namespace {

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
bool read_numbers(std::string_view text, std::vector<NrrdAxis>& axes, double NrrdAxis::*member) {
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

Result<std::vector<NrrdAxis>> read_axes(const std::filesystem::path& path,
                                        const NrrdHeader& header) {
  const auto sizes = whole_numbers(header.field("sizes"));
  const auto dimension = whole_number(header.field("dimension"));
  if (!sizes || sizes->empty() || sizes->size() > 16 || !dimension ||
      *dimension != static_cast<int64_t>(sizes->size()) ||
      *std::min_element(sizes->begin(), sizes->end()) < 1) {
    return malformed_nrrd(path, fmt::format("expected as many sizes above 0 as dimensions, found "
                                            "dimension '{}' and sizes '{}'",
                                            header.field("dimension"), header.field("sizes")));
  }
  std::vector<NrrdAxis> axes(sizes->size());
  for (size_t i = 0; i < axes.size(); ++i) axes[i].size = (*sizes)[i];
  const auto wrong = [&](const char* name) {
    return malformed_nrrd(path, fmt::format("expected one of '{}' for each of {} axes, found '{}'",
                                            name, axes.size(), header.field(name)));
  };
  if (!read_numbers(header.field("spacings"), axes, &NrrdAxis::spacing)) return wrong("spacings");
  if (!read_numbers(header.field("axismins"), axes, &NrrdAxis::min)) return wrong("axismins");
  if (!read_numbers(header.field("axismaxs"), axes, &NrrdAxis::max)) return wrong("axismaxs");
  const auto read_words = [&](const char* name, std::string NrrdAxis::*member) {
    const auto parts = words(header.field(name));
    if (!parts.empty() && parts.size() != axes.size()) return false;
    for (size_t i = 0; i < parts.size(); ++i) axes[i].*member = lower_case(parts[i]);
    return true;
  };
  if (!read_words("kinds", &NrrdAxis::kind)) return wrong("kinds");
  if (!read_words("centers", &NrrdAxis::center)) return wrong("centers");
  if (!header.field("units").empty()) {
    const auto units = quoted_strings(header.field("units"));
    if (!units || units->size() != axes.size()) return wrong("units");
    for (size_t i = 0; i < axes.size(); ++i) axes[i].unit = (*units)[i];
  }
  const auto vectors = split_vectors(header.field("spacedirections"));
  if (!vectors.empty() && vectors.size() != axes.size()) return wrong("spacedirections");
  for (size_t i = 0; i < vectors.size(); ++i) {
    axes[i].is_none = lower_case(vectors[i]) == "none";
    if (axes[i].is_none) continue;
    axes[i].direction = parse_vector(vectors[i]);
    if (!axes[i].direction) return wrong("spacedirections");
  }
  return axes;
}

/// Errors: malformed_volume for axes with a space direction that have components or times
/// according to their kind.
Result<void> check_kinds_of_directions(const std::filesystem::path& path,
                                       const std::vector<NrrdAxis>& axes) {
  for (size_t i = 0; i < axes.size(); ++i) {
    const std::string& kind = axes[i].kind;
    const bool is_other = is_component_kind(kind) || kind == "list" || kind == "time";
    if (axes[i].direction && axes[i].size > 1 && is_other) {
      return malformed_nrrd(
          path, fmt::format("axis {} has a space direction, but its kind is '{}': one of 'kinds' "
                            "and 'space directions' is wrong",
                            i + 1, kind));
    }
  }
  return {};
}

/// Finds the spatial axes, in file order.
std::vector<size_t> find_spatial_axes(const std::vector<NrrdAxis>& axes,
                                      std::vector<std::string>& notes) {
  std::vector<size_t> found;
  const auto collect = [&](auto&& is_one) {
    found.clear();
    for (size_t i = 0; i < axes.size(); ++i) {
      if (is_one(axes[i])) found.push_back(i);
    }
    return found.size();
  };
  if (std::any_of(axes.begin(), axes.end(),
                  [](const NrrdAxis& a) { return a.direction || a.is_none; })) {
    collect([](const NrrdAxis& a) { return a.direction.has_value(); });
    return found;
  }
  if (std::any_of(axes.begin(), axes.end(),
                  [](const NrrdAxis& a) { return !is_unspecified_kind(a.kind); })) {
    // If there are too few spatial axes, axes without any declaration are spatial.
    if (collect([](const NrrdAxis& a) { return is_space_kind(a.kind); }) < 3) {
      collect(
          [](const NrrdAxis& a) { return is_space_kind(a.kind) || is_unspecified_kind(a.kind); });
    }
    return found;
  }
  // A spacing of "nan" marks an axis without spacing; beside axes with spacings it is not spatial.
  if (collect([](const NrrdAxis& a) { return std::isfinite(a.spacing) && a.spacing != 0; }) == 3) {
    return found;
  }
  collect([](const NrrdAxis&) { return true; });
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

/// In a space with time, an axis along time alone is not spatial: its direction is removed.
void mark_time_axes(const NrrdSpace& space, std::vector<NrrdAxis>& axes) {
  for (NrrdAxis& axis : axes) {
    if (space.dimension != 4 || !axis.direction || axis.direction->size() != 4) continue;
    const auto& d = *axis.direction;
    if (d[0] == 0 && d[1] == 0 && d[2] == 0 && d[3] != 0) {
      axis.direction.reset();
      axis.is_none = true;
      if (is_unspecified_kind(axis.kind)) axis.kind = "time";
    }
  }
}

/// The axes with more than one sample that are not spatial. Errors: if there are not three spatial
/// axes and at most one other.
Result<std::vector<size_t>> find_other_axes(const std::filesystem::path& path,
                                            const std::vector<NrrdAxis>& axes,
                                            std::span<const size_t> spatial) {
  std::vector<size_t> others;
  for (size_t i = 0; i < axes.size(); ++i) {
    if (std::find(spatial.begin(), spatial.end(), i) == spatial.end() && axes[i].size > 1)
      others.push_back(i);
  }
  if (spatial.size() != 3) {
    return fail(spatial.size() < 3 ? Status::no_cells : Status::unsupported_format,
                fmt::format("{}: expected a volume with three spatial axes, found an image with "
                            "{}: give the file that contains all slices, or correct 'kinds' and "
                            "'space directions'",
                            path.string(), spatial.size()));
  }
  if (others.size() > 1) {
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected three spatial axes and one of times or channels, found {} "
                    "others: save one volume as a separate file",
                    path.string(), others.size()));
  }
  return others;
}

}  // namespace

Result<NrrdAxes> read_nrrd_axes(const std::filesystem::path& path, const NrrdHeader& header) {
  auto axes = read_axes(path, header);
  if (!axes) return tl::unexpected(axes.error());
  const auto space = read_nrrd_space(path, header);
  if (!space) return tl::unexpected(space.error());
  mark_time_axes(*space, *axes);
  if (auto fit = check_kinds_of_directions(path, *axes); !fit) return tl::unexpected(fit.error());

  NrrdAxes result;
  const std::vector<size_t> spatial = find_spatial_axes(*axes, result.notes);
  const auto others = find_other_axes(path, *axes, spatial);
  if (!others) return tl::unexpected(others.error());
  result.voxels = {(*axes)[spatial[0]].size, (*axes)[spatial[1]].size, (*axes)[spatial[2]].size};
  if (!others->empty()) {
    const size_t other = others->front();
    const NrrdAxis& axis = (*axes)[other];
    result.steps = axis.size;
    const double first = std::isfinite(axis.min) ? axis.min : 0;
    const bool are_layers = header.has_segments && axis.kind == "list";
    result.are_channels = is_component_kind(axis.kind) || are_layers;
    if (axis.kind == "rgb-color" || axis.kind == "rgba-color") result.channels = rgba_channels();
    if (!result.are_channels) {
      result.times = TimeAxis::regular(first, axis.spacing, axis.size, axis.unit);
    }
    result.step_axis = static_cast<size_t>(
        std::count_if(spatial.begin(), spatial.end(), [&](size_t i) { return i < other; }));
  }
  auto geometry =
      nrrd_geometry(path, header, *axes, std::span<const size_t, 3>(spatial), *space, result.notes);
  if (!geometry) return tl::unexpected(geometry.error());
  result.geometry = *geometry;
  return result;
}

}  // namespace isosplat::import
