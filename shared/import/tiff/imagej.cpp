#include <fmt/format.h>

#include <cmath>

#include "shared/import/text/header_text.h"
#include "shared/import/tiff/series.h"

// Reads the description that ImageJ writes into the first page, lines of the form name=value, and
// the one of ImageJ2 and Fiji's SCIFIO, which has lists of axes as well.
namespace isosplat::import {
namespace {

/// The value of a line `name=…`.
std::optional<std::string_view> line_value(std::string_view text, std::string_view name) {
  for (size_t at = 0; (at = text.find(name, at)) != text.npos; at += name.size()) {
    const bool begins = at == 0 || text[at - 1] == '\n';
    const size_t equals = at + name.size();
    if (!begins || equals >= text.size() || text[equals] != '=') continue;
    const size_t end = std::min(text.find('\n', equals), text.size());
    return trimmed(text.substr(equals + 1, end - equals - 1));
  }
  return std::nullopt;
}

/// Reads ImageJ's calibration function of values ("cf"): 0 is a straight line with the coefficients
/// c0 and c1; the others are curves, which are not applied. Errors: malformed_volume.
Result<void> read_calibration(const std::filesystem::path& path, std::string_view text,
                              TiffSeries& series) {
  const auto function = line_value(text, "cf");
  if (!function || function == "20") return {};  // 20: none
  if (function != "0") {
    series.notes.push_back(
        fmt::format("ImageJ's calibration of values (function {}) is not a straight line: it is "
                    "not applied, the values are those stored",
                    *function));
    return {};
  }
  const auto c0 = number_in(line_value(text, "c0").value_or(""));
  const auto c1 = number_in(line_value(text, "c1").value_or(""));
  if (!c0 || !c1 || !std::isfinite(*c0) || !std::isfinite(*c1) || *c1 == 0) {
    return fail(Status::malformed_volume,
                path.string() +
                    ": expected numbers c0 and c1, c1 not 0, of the calibration of values in its "
                    "ImageJ description");
  }
  series.intercept = *c0;
  series.slope = *c1;
  return {};
}

/// ImageJ's lengths: the resolution is in pixels per unit, `spacing` is the slice distance. Only
/// the distance along z may have a sign, which has no meaning.
void read_lengths(std::string_view text, const TiffPage& first, TiffSeries& series) {
  std::string unit(line_value(text, "unit").value_or(""));
  if (unit.empty() && first.resolution_unit == 3) unit = "cm";
  series.units = {unit, std::string(line_value(text, "yunit").value_or(unit)),
                  std::string(line_value(text, "zunit").value_or(unit))};
  const auto pixel = [](std::optional<double> per_unit) {
    return per_unit.value_or(0) > 0 ? 1 / *per_unit : 1;
  };
  const auto spacing = number_in(line_value(text, "spacing").value_or(""));
  const bool has_spacing = spacing && *spacing != 0 && std::isfinite(*spacing);
  if (!has_spacing && unit.empty()) return;
  series.lengths = {pixel(first.pixels_per_unit_x), pixel(first.pixels_per_unit_y),
                    has_spacing ? std::optional(std::abs(*spacing)) : std::nullopt};
  if (has_spacing || lower_case(unit).starts_with("pixel")) return;
  series.lengths[2] = 1;
  series.notes.push_back(fmt::format(
      "the ImageJ description has no spacing, which ImageJ leaves out if it is 1: the distance "
      "between slices is 1 {}; --spacing sets another",
      unit));
}

/// ImageJ's interval between frames. Its unit is the second, which it calls "sec", unless the
/// description names another one.
void read_times(std::string_view text, TiffSeries& series) {
  series.time_distance = number_in(line_value(text, "finterval").value_or("")).value_or(0);
  const std::string_view unit = line_value(text, "tunit").value_or("sec");
  series.time_unit = unit == "sec" ? "s" : unit;
}

/// SCIFIO's axes beyond x and y, in the order of the pages. Errors: unsupported_format for an axis
/// that is neither z, channels nor time.
Result<void> read_scifio_order(const std::filesystem::path& path, std::string_view text,
                               TiffSeries& series) {
  const auto axes = line_value(text, "axes");
  if (!axes) return {};
  std::vector<TiffAxis> order;
  std::string_view rest = *axes;
  while (!rest.empty()) {
    const size_t comma = std::min(rest.find(','), rest.size());
    const std::string name = lower_case(trimmed(rest.substr(0, comma)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
    if (name == "x" || name == "y") continue;
    if (name == "z") {
      order.push_back(TiffAxis::z);
    } else if (name == "channel") {
      order.push_back(TiffAxis::channel);
    } else if (name == "time") {
      order.push_back(TiffAxis::time);
    } else {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected the axes X, Y, Z, Channel and Time, found {}: save one "
                              "volume as a separate file in Fiji (Image > Duplicate)",
                              path.string(), name));
    }
  }
  for (const TiffAxis axis : {TiffAxis::channel, TiffAxis::z, TiffAxis::time}) {
    if (std::find(order.begin(), order.end(), axis) == order.end()) order.push_back(axis);
  }
  if (order.size() == 3) std::copy(order.begin(), order.end(), series.order.begin());
  return {};
}

}  // namespace

bool is_imagej(std::string_view text) {
  return text.starts_with("ImageJ=") || text.starts_with("SCIFIO=");
}

TiffSeriesList imagej_series(const std::filesystem::path& path, const TiffPages& pages,
                             const TiffPage& first) {
  const std::string_view text = first.description;
  TiffSeries series;
  const auto count = [&](const char* name) -> std::optional<uint64_t> {
    const auto value = line_value(text, name);
    if (!value) return std::nullopt;
    const auto number = whole_number(*value);
    return number && *number > 0 && *number < int64_t{1} << 20 ? static_cast<uint64_t>(*number) : 0;
  };
  const auto images = count("images");
  const uint64_t channels = count("channels").value_or(1), frames = count("frames").value_or(1),
                 others = channels * frames;
  const auto stated = count("slices");
  const uint64_t slices = stated ? *stated : others > 0 ? images.value_or(1) / others : 0;
  if (channels == 0 || frames == 0 || slices == 0 || images == uint64_t{0}) {
    return fail(Status::malformed_volume,
                path.string() + ": expected numbers above 0 in its ImageJ description");
  }
  if (images && *images != channels * slices * frames) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected channels × slices × frames = images in its ImageJ "
                            "description, found {} × {} × {} and {}",
                            path.string(), channels, slices, frames, *images));
  }
  series.sizes = {slices, channels, frames};
  series.counted = images.has_value();
  series.pages = images.value_or(pages.offsets.size());
  if (!images) series.sizes = {series.pages, 1, 1};
  // ImageJ writes stacks of more than 4 GB as one page, followed by the voxels of the others.
  series.follow = pages.offsets.size() == 1 && series.pages > 1 && !pages.ends_early;
  read_lengths(text, first, series);
  read_times(text, series);
  if (auto fine = read_calibration(path, text, series); !fine) return tl::unexpected(fine.error());
  if (text.starts_with("SCIFIO=")) {
    if (auto fine = read_scifio_order(path, text, series); !fine) {
      return tl::unexpected(fine.error());
    }
  }
  return std::vector{std::move(series)};
}

}  // namespace isosplat::import
