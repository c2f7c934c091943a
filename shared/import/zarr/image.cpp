#include "shared/import/zarr/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/bytes/input_files.h"
#include "shared/import/text/header_text.h"

namespace isosplat::import::zarr {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxScales = 64;

tl::unexpected<Error> malformed(const fs::path& folder, const std::string& what) {
  return fail(Status::malformed_volume, fmt::format("{}: {}", folder.string(), what));
}

/// Version 0.5 has its metadata in a member `ome`.
Json ome_of(const Json& attributes) {
  const Json ome = member(attributes, "ome");
  return ome.is_object() ? ome : attributes;
}

/// The first entry of multiscales; null if there is none.
Json multiscale_of(const Json& attributes) {
  const Json all = member(ome_of(attributes), "multiscales");
  return all.is_array() && !all.empty() && all[0].is_object() ? all[0] : Json();
}

/// Applies scales and translations, in their order.
Result<void> apply(const Json& steps, Scale& scale, const fs::path& folder) {
  for (const Json& step : steps.is_array() ? steps : Json::array()) {
    const std::string type = string_of(step, "type");
    if (type != "scale" && type != "translation") continue;
    const Json numbers = member(step, type.c_str());
    const size_t rank = scale.scale.size();
    bool is_valid = numbers.is_array() && numbers.size() == rank;
    for (const Json& each : is_valid ? numbers : Json::array()) {
      is_valid = is_valid && each.is_number() && std::isfinite(each.get<double>()) &&
                 (type == "translation" || each.get<double>() > 0);
    }
    if (!is_valid) {
      return malformed(folder, fmt::format("expected {} {} as {}, found {}", rank,
                                           type == "scale" ? "positive numbers" : "numbers", type,
                                           text_of(numbers)));
    }
    for (size_t i = 0; i < rank; ++i) {
      const double number = numbers[i].get<double>();
      if (type == "scale") {
        scale.scale[i] *= number;
        scale.translation[i] *= number;
      } else {
        scale.translation[i] += number;
      }
    }
  }
  return {};
}

/// In versions 0.1 and 0.2 the axes are t, c, z, y, x.
Result<std::vector<Axis>> axes_of(const Json& multiscale, size_t rank, const fs::path& folder) {
  const Json stated = member(multiscale, "axes");
  std::vector<Axis> axes;
  if (stated.is_null()) {
    constexpr std::array kNames{"t", "c", "z", "y", "x"};
    for (size_t i = rank; i-- > 0;) {
      if (i < kNames.size()) axes.push_back({kNames[kNames.size() - 1 - i], ""});
    }
  }
  for (const Json& axis : stated.is_array() ? stated : Json::array()) {
    if (axis.is_string()) {
      axes.push_back({axis.get<std::string>(), ""});
    } else if (member(axis, "name").is_string()) {
      axes.push_back({string_of(axis, "name"), string_of(axis, "unit")});
    }
  }
  if (axes.size() == rank) return axes;
  return malformed(
      folder, fmt::format("expected {} axes with names, as many as the array has, found {}", rank,
                          text_of(stated)));
}

std::vector<ChannelDescription> channels_of(const Json& attributes) {
  std::vector<ChannelDescription> channels;
  const Json stated = member(member(ome_of(attributes), "omero"), "channels");
  for (const Json& each : stated.is_array() ? stated : Json::array()) {
    ChannelDescription channel{string_of(each, "label"), std::nullopt};
    const std::string colour = string_of(each, "color");
    const bool is_colour =
        colour.size() == 6 && std::all_of(colour.begin(), colour.end(), [](char c) {
          return std::isxdigit(static_cast<unsigned char>(c)) != 0;
        });
    if (is_colour) {
      const auto part = [&](size_t at) {
        return static_cast<float>(std::stoi(colour.substr(at, 2), nullptr, 16)) / 255.0f;
      };
      channel.colour = {part(0), part(2), part(4)};
    }
    channels.push_back(std::move(channel));
  }
  return channels;
}

Result<Image> read_multiscale(const fs::path& folder, const Json& attributes,
                              const Json& multiscale) {
  Image image;
  image.folder = folder;
  image.is_ome = true;
  image.channels = channels_of(attributes);
  const Json datasets = member(multiscale, "datasets");
  const bool is_list = datasets.is_array() && !datasets.empty() && datasets.size() <= kMaxScales;
  for (const Json& dataset : is_list ? datasets : Json::array()) {
    const std::string path = string_of(dataset, "path");
    // A path from strangers stays below the image.
    if (path.empty() || path.find("..") != path.npos || fs::path(path).is_absolute()) break;
    const auto node = read_node(folder / path);
    if (!node) return tl::unexpected(node.error());
    if (!node->array) {
      return malformed(folder, fmt::format("expected an array at {}, found a group", path));
    }
    const size_t rank = node->array->grid.sizes.size();
    auto axes = axes_of(multiscale, rank, folder);
    if (!axes) return tl::unexpected(axes.error());
    image.axes = std::move(*axes);
    Scale scale{path, std::vector<double>(rank, 1), std::vector<double>(rank, 0)};
    for (const Json& steps : {member(dataset, "coordinateTransformations"),
                              member(multiscale, "coordinateTransformations")}) {
      if (auto applied = apply(steps, scale, folder); !applied) {
        return tl::unexpected(applied.error());
      }
    }
    image.scales.push_back(std::move(scale));
  }
  if (image.scales.empty() || image.scales.size() != datasets.size()) {
    return malformed(folder,
                     fmt::format("expected 1 to {} datasets with paths in multiscales, found {}",
                                 kMaxScales, text_of(datasets)));
  }
  return image;
}

/// Images that are arrays of the group above.
Result<std::optional<Image>> image_above(const fs::path& folder) {
  const fs::path parent = folder.parent_path();
  if (!is_node(parent)) return std::nullopt;
  const auto node = read_node(parent);
  if (!node || node->array) return std::nullopt;
  const Json multiscale = multiscale_of(node->attributes);
  if (multiscale.is_null()) return std::nullopt;
  auto image = read_multiscale(parent, node->attributes, multiscale);
  if (!image) return std::nullopt;
  const auto scale = std::find_if(image->scales.begin(), image->scales.end(), [&](const Scale& s) {
    return s.path == folder.filename().string();
  });
  if (scale == image->scales.end()) return std::nullopt;
  image->chosen = static_cast<size_t>(scale - image->scales.begin());
  return std::optional(std::move(*image));
}

}  // namespace

Result<Image> read_image(const fs::path& path) {
  const fs::path folder = path.has_filename() ? path : path.parent_path();
  const auto node = read_node(folder);
  if (!node) return tl::unexpected(node.error());
  if (node->array) {
    auto above = image_above(folder);
    if (!above) return tl::unexpected(above.error());
    if (*above) return std::move(**above);
    const size_t rank = node->array->grid.sizes.size();
    Image image;
    image.folder = folder;
    image.scales = {{"", std::vector<double>(rank, 1), std::vector<double>(rank, 0)}};
    image.chosen = 0;
    for (const std::string& name : node->array->dimension_names) image.axes.push_back({name, ""});
    if (image.axes.empty()) image.axes.resize(rank);
    return image;
  }
  if (const Json multiscale = multiscale_of(node->attributes); !multiscale.is_null()) {
    return read_multiscale(folder, node->attributes, multiscale);
  }
  const Json ome = ome_of(node->attributes);
  const bool is_collection =
      ome.contains("bioformats2raw.layout") || node->attributes.contains("bioformats2raw.layout");
  if (is_collection && is_node(folder / "0")) {
    const auto first = read_node(folder / "0");
    if (!first) return tl::unexpected(first.error());
    const Json multiscale = multiscale_of(first->attributes);
    if (!multiscale.is_null()) return read_multiscale(folder / "0", first->attributes, multiscale);
  }
  return fail(
      Status::unsupported_format,
      fmt::format("{}: expected an image or an array, found {}: give the folder of one "
                  "image or array in it",
                  folder.string(),
                  ome.contains("plate") ? "a plate of images" : "a group without multiscales"));
}

Result<std::array<size_t, 3>> spatial_axes(const std::vector<Axis>& axes, const fs::path& folder) {
  const size_t rank = axes.size();
  const auto at = [&](const char* name) {
    const auto found = std::find_if(
        axes.begin(), axes.end(), [&](const Axis& axis) { return lower_case(axis.name) == name; });
    return static_cast<size_t>(found - axes.begin());
  };
  const std::array<size_t, 3> named{at("x"), at("y"), at("z")};
  const auto named_axes =
      std::count_if(named.begin(), named.end(), [&](size_t i) { return i < rank; });
  if (named_axes == 3) return named;
  if (rank >= 3 && named_axes == 0) return std::array<size_t, 3>{rank - 1, rank - 2, rank - 3};
  std::vector<std::string> names;
  for (const Axis& axis : axes) names.push_back(axis.name);
  return fail(Status::no_cells,
              fmt::format("{}: expected the axes x, y and z, found {}: it is no volume",
                          folder.string(), fmt::join(names, ", ")));
}

HeaderGeometry geometry_of(const Scale& scale, const std::vector<Axis>& axes,
                           const std::array<size_t, 3>& spatial, std::vector<std::string>& notes) {
  constexpr std::pair<std::string_view, double> kMillimetres[] = {
      {"angstrom", 1e-7}, {"nanometer", 1e-6}, {"micrometer", 1e-3}, {"millimeter", 1},
      {"centimeter", 10}, {"decimeter", 100},  {"meter", 1000},      {"kilometer", 1e6},
      {"inch", 25.4},     {"foot", 304.8},
  };
  std::array<double, 3> factors{1, 1, 1};
  std::string problem;
  for (size_t i = 0; i < 3; ++i) {
    const std::string& unit = axes[spatial[i]].unit;
    const auto* const found = std::find_if(std::begin(kMillimetres), std::end(kMillimetres),
                                           [&](const auto& known) { return known.first == unit; });
    if (found != std::end(kMillimetres)) {
      factors[i] = found->second;
    } else if (problem.empty()) {
      problem = unit.empty() ? "its lengths have no unit"
                             : fmt::format("its unit {} is unknown", text_of(unit));
    }
  }
  if (!problem.empty()) notes.push_back(problem + ": millimetres are assumed");
  const auto of = [&](const std::vector<double>& values) {
    return Vec3d{values[spatial[0]] * factors[0], values[spatial[1]] * factors[1],
                 values[spatial[2]] * factors[2]};
  };
  HeaderGeometry geometry;
  geometry.spacing = of(scale.scale);
  geometry.origin = of(scale.translation);
  return geometry;
}

std::string name_of(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::path& part : folder.lexically_normal()) {
    const std::string name = part.string();
    if (name.empty() || name == "/" || name == ".") continue;
    const bool is_image = lower_case(name).ends_with(".zarr");
    if (is_image) names.clear();
    const bool is_below = !names.empty() && lower_case(names.front()).ends_with(".zarr");
    if (!is_image && !is_below) names.clear();
    names.push_back(name);
  }
  std::string text = fmt::format("{}", fmt::join(names, "-"));
  for (const std::string_view ending : {".ome.zarr", ".zarr"}) {
    if (const size_t at = lower_case(text).find(ending); at != text.npos) {
      text.erase(at, ending.size());
    }
  }
  return text.empty() ? "volume" : text;
}

}  // namespace isosplat::import::zarr
