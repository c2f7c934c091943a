#include <fmt/format.h>

#include <algorithm>

#include "shared/import/text/header_text.h"
#include "shared/import/tiff/series.h"

// Reads the descriptions that Python's tifffile writes: {"shape": [6, 7, 8], "axes": "ZYX"}, or
// shape=(6, 7, 8) in versions before 2017. Each array of a file has a description in its first
// page.
namespace isosplat::import {
namespace {

constexpr uint64_t kMaxText = 1 << 20;

/// The text after `"name":` in a JSON object; empty if the object has no such name.
std::string_view value_of(std::string_view json, std::string_view name) {
  const std::string key = fmt::format("\"{}\"", name);
  const size_t at = json.find(key);
  if (at == json.npos) return {};
  const std::string_view rest = trimmed(json.substr(at + key.size()));
  return rest.starts_with(':') ? trimmed(rest.substr(1)) : std::string_view{};
}

std::string text_of(std::string_view json, std::string_view name) {
  const std::string_view value = value_of(json, name);
  if (!value.starts_with('"')) return {};
  return std::string(value.substr(1, value.find('"', 1) - 1));
}

std::optional<double> number_of(std::string_view json, std::string_view name) {
  const std::string_view value = value_of(json, name);
  return number_in(trimmed(value.substr(0, value.find_first_of(",}"))));
}

/// The numbers between brackets: "[6, 7, 8]" or "(6, 7, 8)".
std::optional<std::vector<int64_t>> shape_of(std::string_view text) {
  std::string_view list = text.starts_with("shape=") ? text.substr(6) : value_of(text, "shape");
  if (list.empty() || (list[0] != '[' && list[0] != '(')) return std::nullopt;
  const size_t end = list.find_first_of("])");
  if (end == list.npos) return std::nullopt;
  std::string numbers(list.substr(1, end - 1));
  std::replace(numbers.begin(), numbers.end(), ',', ' ');
  auto shape = whole_numbers(numbers);
  if (!shape || shape->empty() || shape->size() > 32) return std::nullopt;
  for (const int64_t size : *shape) {
    if (size < 1 || size > int64_t{1} << 40) return std::nullopt;
  }
  return shape;
}

tl::unexpected<Error> other_shape(const std::filesystem::path& path, std::string_view text,
                                  const TiffPageKind& kind) {
  return fail(Status::malformed_volume,
              fmt::format("{}: expected an array like its description says ({}), found pages of {} "
                          "× {} voxels: write it again with tifffile",
                          path.string(), trimmed(text.substr(0, 200)), kind.width, kind.height));
}

/// One array, whose first page has the description `text`.
Result<TiffSeries> array_of(const std::filesystem::path& path, std::string_view text,
                            const TiffPageKind& kind) {
  TiffSeries series;
  const auto found = shape_of(text);
  if (!found) return other_shape(path, text, kind);
  std::vector<int64_t> shape = *found;
  std::string axes = text_of(text, "axes");
  if (axes.size() != shape.size()) axes.assign(shape.size(), '?');
  const auto pop = [&](uint64_t size, size_t at) {
    if (at >= shape.size() || static_cast<uint64_t>(shape[at]) != size) return false;
    shape.erase(shape.begin() + static_cast<std::ptrdiff_t>(at));
    axes.erase(at, 1);
    return true;
  };
  // The axes, beginning with the last one: samples, if they are the fastest; x; y; slices of one
  // page, if there are several; samples, if they are not the fastest.
  const bool several = kind.samples > 1;
  const size_t n = shape.size();
  const bool samples_last = several && n >= 3 &&
                            static_cast<uint64_t>(shape[n - 1]) == kind.samples &&
                            static_cast<uint64_t>(shape[n - 2]) == kind.width;
  const char samples_letter = axes.back();
  if (samples_last && !pop(kind.samples, n - 1)) return other_shape(path, text, kind);
  if (!pop(kind.width, shape.size() - 1)) return other_shape(path, text, kind);
  if (!pop(kind.height, shape.size() - 1) && kind.height != 1) return other_shape(path, text, kind);
  if (kind.depth > 1) {
    if (!pop(kind.depth, shape.size() - 1)) return other_shape(path, text, kind);
    series.depth_is_z = true;
    series.size(TiffAxis::z) = kind.depth;
  }
  if (several) {
    const char letter = samples_last ? samples_letter : axes.empty() ? '?' : axes.back();
    if (!samples_last && !pop(kind.samples, shape.size() - 1)) {
      return other_shape(path, text, kind);
    }
    series.in_samples = letter == 'Z'   ? TiffAxis::z
                        : letter == 'T' ? TiffAxis::time
                                        : TiffAxis::channel;
    if (series.depth_is_z && letter == 'Z') return other_shape(path, text, kind);
    series.size(*series.in_samples) = kind.samples;
  }
  uint64_t planes = 1;
  for (size_t i = 0; i < shape.size(); ++i) {
    if (static_cast<uint64_t>(shape[i]) > (uint64_t{1} << 40) / planes) {
      return other_shape(path, text, kind);
    }
    planes *= static_cast<uint64_t>(shape[i]);
  }
  series.pages = planes;
  series.counted = true;
  for (size_t i = shape.size(); i-- > 0;) {
    if (shape[i] == 1) pop(1, i);
  }

  // The axes of pages, from the slowest to the fastest.
  std::vector<TiffAxis> order;
  const auto take = [&](TiffAxis axis, int64_t size) {
    const bool is_free =
        std::find(order.begin(), order.end(), axis) == order.end() && series.size(axis) == 1;
    if (is_free) order.push_back(axis), series.size(axis) = static_cast<uint64_t>(size);
    return is_free;
  };
  const bool named = axes.find_first_not_of("ZCTS") == axes.npos;
  bool known = true;
  if (named) {
    for (size_t i = 0; i < shape.size(); ++i) {
      const TiffAxis axis = axes[i] == 'Z'   ? TiffAxis::z
                            : axes[i] == 'T' ? TiffAxis::time
                                             : TiffAxis::channel;
      known = known && take(axis, shape[i]);
    }
  } else {
    const bool has_z = series.size(TiffAxis::z) > 1;
    known = shape.size() <= (has_z ? 1u : 2u);
    for (size_t i = 0; known && i < shape.size(); ++i) {
      const bool is_last = i + 1 == shape.size() && !has_z;
      const bool is_time = axes[i] == 'T', is_channel = axes[i] == 'C';
      known = take(is_last && !is_time && !is_channel ? TiffAxis::z
                   : is_channel                       ? TiffAxis::channel
                                                      : TiffAxis::time,
                   shape[i]);
      if (!is_last && !is_time && !is_channel) series.unnamed = true;
    }
  }
  if (!known) {
    return fail(
        Status::unsupported_format,
        fmt::format("{}: expected an array with the axes time, channel, z, y and x, found {}: save "
                    "one volume as a separate file, such as python -c \"import tifffile; a = "
                    "tifffile.imread('{}'); tifffile.imwrite('volume.tif', "
                    "a.reshape(-1, *a.shape[-3:])[0])\"",
                    path.string(), trimmed(text.substr(0, 200)), path.filename().string()));
  }
  for (const TiffAxis axis : {TiffAxis::time, TiffAxis::z, TiffAxis::channel}) {
    if (std::find(order.begin(), order.end(), axis) == order.end()) {
      order.insert(order.begin(), axis);
    }
  }
  std::copy(order.rbegin(), order.rend(), series.order.begin());
  return series;
}

void read_lengths(std::string_view text, const TiffPage& first, TiffSeries& series) {
  const std::string unit = text_of(text, "unit");
  const auto spacing = number_of(text, "spacing");
  if (spacing && *spacing > 0) {
    series.lengths[2] = *spacing;
    series.units[2] = unit;
  }
  // If the unit of resolution is another one, tiff_geometry uses that.
  if (unit.empty() || first.resolution_unit != 1 || !first.pixels_per_unit_x) return;
  const auto pixel = [](std::optional<double> per_unit) -> std::optional<double> {
    if (!(per_unit.value_or(0) > 0)) return std::nullopt;
    return 1 / *per_unit;
  };
  series.lengths[0] = pixel(first.pixels_per_unit_x);
  series.lengths[1] = pixel(first.pixels_per_unit_y);
  series.units = {unit, unit, unit};
}

}  // namespace

bool is_shaped(std::string_view text) {
  return (text.starts_with('{') && text.find("\"shape\":") != text.npos) ||
         text.starts_with("shape=(");
}

TiffSeriesList shaped_series(const std::filesystem::path& path, const TiffPages& pages,
                             const TiffPage& first) {
  auto reader = TiffDirectoryReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  const uint64_t found = pages.offsets.size();
  std::vector<TiffSeries> all;
  // The page after an array is the first one of another array.
  for (uint64_t page = 0; page < found;) {
    const TiffPageEntry& entry = pages.entries[static_cast<size_t>(page)];
    const std::string text =
        entry.description ? reader->text(*entry.description, kMaxText) : std::string();
    if (!is_shaped(text)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a description like that of the first page in page {}, "
                              "since no earlier description includes this page: write it again "
                              "with tifffile",
                              path.string(), page));
    }
    auto series = array_of(path, text, entry.kind);
    if (!series) return tl::unexpected(series.error());
    series->first_page = page;
    series->name = text_of(text, "name");
    read_lengths(text, first, *series);
    // Whether the next pages have separate directories.
    uint64_t following = 1;
    while (following < series->pages && page + following < found) {
      const TiffPageEntry& next = pages.entries[static_cast<size_t>(page + following)];
      const std::string other = next.description ? reader->text(*next.description, kMaxText) : "";
      if (!(next.kind == entry.kind) || is_shaped(other)) break;
      ++following;
    }
    series->follow = following == 1 && series->pages > 1 && !pages.ends_early;
    const uint64_t step = series->follow ? 1 : following;
    all.push_back(std::move(*series));
    page += step;
    if (all.size() > 10000) break;
  }
  return all;
}

}  // namespace isosplat::import
