#include "shared/import/tiff/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/text/header_text.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {
namespace {

/// Whether a resolution is a default of screens or printers, which programs write without a
/// meaning.
bool is_default(double dots_per_inch) {
  for (const double usual : {1., 72., 75., 96., 100., 120., 144., 150., 180., 200., 240., 300.,
                             350., 360., 400., 600., 1200., 2400.}) {
    if (std::abs(dots_per_inch - usual) < 0.5) return true;
  }
  return false;
}

/// The size of a pixel in mm by the page's resolution. Nothing if the resolution has no meaning.
std::optional<double> pixel_size(const TiffPage& page, std::optional<double> per_unit) {
  const bool is_inch = page.resolution_unit == 2, is_cm = page.resolution_unit == 3;
  if ((!is_inch && !is_cm) || !(per_unit.value_or(0) > 0)) return std::nullopt;
  const double unit = is_inch ? 25.4 : 10;
  if (is_default(*per_unit * 25.4 / unit)) return std::nullopt;
  return unit / *per_unit;
}

}  // namespace

HeaderGeometry tiff_geometry(const TiffPage& page, const TiffSeries& series,
                             const ImportOptions& options, std::vector<std::string>& notes) {
  HeaderGeometry geometry;
  if (options.spacing) {
    geometry.spacing = *options.spacing;
    return geometry;
  }
  auto lengths = series.lengths;
  auto units = series.units;
  if (!lengths[0] && !lengths[1]) {
    lengths[0] = pixel_size(page, page.pixels_per_unit_x);
    lengths[1] = pixel_size(page, page.pixels_per_unit_y);
    units[0] = units[1] = "mm";
    if (!lengths[2]) units[2] = "mm";
  }
  if (!lengths[0] && !lengths[1] && !lengths[2]) {
    notes.push_back(
        "the TIFF file has no distance between slices: spacing 1,1,1 is assumed; --spacing sets "
        "another");
    return geometry;
  }
  const auto unit_text = [](const std::string& unit) { return unit.empty() ? "" : " " + unit; };
  if (!lengths[0] != !lengths[1]) {
    const size_t known = lengths[0] ? 0 : 1;
    lengths[1 - known] = lengths[known];
    units[1 - known] = units[known];
    notes.push_back(fmt::format(
        "the file states the size of pixels along {} only: it is taken for {} too; --spacing sets "
        "another",
        known == 0 ? "x" : "y", known == 0 ? "y" : "x"));
  }
  if (!lengths[0]) {
    lengths[0] = lengths[1] = 1;
    units[0] = units[1] = units[2];
    notes.push_back(fmt::format(
        "the file states a distance between slices of {:.6g}{}, and no size of pixels: 1{} is "
        "assumed; --spacing sets another",
        *lengths[2], unit_text(units[2]), unit_text(units[2])));
  }
  if (!lengths[2]) {
    // OME's lengths have units, so 1 is assumed; other lengths are assumed equal to the pixel size.
    lengths[2] = series.ome.empty() ? *lengths[0] : 1;
    if (series.ome.empty()) units[2] = units[0];
    notes.push_back(fmt::format(
        "the file states pixels of {:.6g} × {:.6g}{}, and no distance "
        "between slices: {:.6g}{} is assumed; --spacing sets another",
        *lengths[0], *lengths[1], unit_text(units[0]), *lengths[2], unit_text(units[2])));
  }
  geometry.spacing = {*lengths[0], *lengths[1], *lengths[2]};
  spacing_to_millimetres(units, geometry, notes);
  return geometry;
}

}  // namespace isosplat::import
