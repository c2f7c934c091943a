#include "shared/import/geometry/conventions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

void negate_row(size_t row, HeaderGeometry& geometry) {
  double* const origin[] = {&geometry.origin.x, &geometry.origin.y, &geometry.origin.z};
  *origin[row] = 0 - *origin[row];
  for (size_t axis = 0; axis < 3; ++axis) {
    geometry.direction[3 * row + axis] = 0 - geometry.direction[3 * row + axis];
  }
}

/// Whether a unit is "µm" with the first letter in another encoding: as an XML entity, as the
/// escape \\u00b5, in Latin-1, encoded twice, or replaced by a question mark. No other letter
/// outside of ASCII precedes "m" in a unit of length.
bool is_micro_metre(std::string_view lower) {
  if (!lower.ends_with('m')) return false;
  lower.remove_suffix(1);
  for (const char* written :
       {"&#181;", "&#xb5;", "&#956;", "&#x3bc;", "&micro;", "&mu;", "\\u00b5", "\\u03bc", "?"}) {
    if (lower == written) return true;
  }
  return !lower.empty() &&
         std::all_of(lower.begin(), lower.end(), [](char c) { return (c & 0x80) != 0; });
}

/// Whether the letter before "m" cannot be recognized any more.
bool is_lost_letter(std::string_view unit) {
  return unit == "?m" || unit == "\ufffdm";
}

/// Millimetres per unit of length. A note says that the unit is unknown or hardly readable.
double millimetres_or_note(std::string_view unit, std::vector<std::string>& notes) {
  const auto factor = millimetres_in(unit);
  if (!factor) {
    notes.push_back(
        fmt::format("lengths are in the unknown unit '{}': they are read as millimetres", unit));
  } else if (is_lost_letter(trimmed(unit))) {
    notes.push_back(fmt::format(
        "a letter of the unit of length is lost ('{}'): it is read as micrometres", unit));
  }
  return factor.value_or(1);
}

}  // namespace

HeaderGeometry geometry_of_steps(const std::array<Vec3d, 3>& steps, Vec3d origin) {
  HeaderGeometry geometry;
  geometry.origin = origin;
  double* const spacing[] = {&geometry.spacing.x, &geometry.spacing.y, &geometry.spacing.z};
  for (size_t axis = 0; axis < 3; ++axis) {
    const Vec3d step = steps[axis];
    const double length = std::hypot(step.x, step.y, step.z);
    *spacing[axis] = length;
    const double divisor = length > 0 && std::isfinite(length) ? length : 1;
    geometry.direction[axis] = step.x / divisor;
    geometry.direction[3 + axis] = step.y / divisor;
    geometry.direction[6 + axis] = step.z / divisor;
  }
  return geometry;
}

HeaderGeometry geometry_of_spacing(Vec3d spacing, Vec3d origin) {
  HeaderGeometry geometry;
  geometry.origin = origin;
  const double given[] = {spacing.x, spacing.y, spacing.z};
  double* const lengths[] = {&geometry.spacing.x, &geometry.spacing.y, &geometry.spacing.z};
  for (size_t axis = 0; axis < 3; ++axis) {
    *lengths[axis] = std::abs(given[axis]);
    if (given[axis] < 0) geometry.direction[4 * axis] = -1;
  }
  return geometry;
}

void to_lps(Frame frame, HeaderGeometry& geometry) {
  switch (frame) {
    case Frame::lps:
      break;
    case Frame::ras:
      negate_row(0, geometry);
      negate_row(1, geometry);
      break;
    case Frame::las:
      negate_row(1, geometry);
      break;
    case Frame::left_handed:
      negate_row(2, geometry);
      break;
  }
}

void scale_lengths(double factor, HeaderGeometry& geometry) {
  geometry.spacing = geometry.spacing * factor;
  geometry.origin = geometry.origin * factor;
}

std::optional<std::array<Vec3d, 3>> cell_axes(const std::array<double, 3>& angles) {
  std::array<double, 3> cosines{};
  for (size_t i = 0; i < 3; ++i) {
    if (!(angles[i] > 0 && angles[i] < 180)) return std::nullopt;
    // Right angles give exactly 0.
    cosines[i] = angles[i] == 90 ? 0 : std::cos(angles[i] * std::numbers::pi / 180);
  }
  const auto [a, b, c] = cosines;
  const double sine = std::sqrt(1 - c * c), y = (a - b * c) / sine, square = 1 - b * b - y * y;
  if (!(square > 1e-6)) return std::nullopt;
  return std::array{Vec3d{1, 0, 0}, Vec3d{c, sine, 0}, Vec3d{b, y, std::sqrt(square)}};
}

std::optional<double> millimetres_in(std::string_view unit) {
  struct Unit {
    std::string_view name;
    double millimetres;
  };
  static constexpr Unit kUnits[] = {{"mm", 1},
                                    {"millimeter", 1},
                                    {"millimetre", 1},
                                    {"millimeters", 1},
                                    {"millimetres", 1},
                                    {"cm", 10},
                                    {"centimeter", 10},
                                    {"centimetre", 10},
                                    {"m", 1000},
                                    {"meter", 1000},
                                    {"metre", 1000},
                                    {"meters", 1000},
                                    {"metres", 1000},
                                    {"dm", 100},
                                    {"um", 1e-3},
                                    {"\u00b5", 1e-3},
                                    {"\u03bc", 1e-3},
                                    {"micron", 1e-3},
                                    {"microns", 1e-3},
                                    {"micrometer", 1e-3},
                                    {"micrometre", 1e-3},
                                    {"micrometers", 1e-3},
                                    {"micrometres", 1e-3},
                                    {"nm", 1e-6},
                                    {"nanometer", 1e-6},
                                    {"nanometre", 1e-6},
                                    {"nanometers", 1e-6},
                                    {"nanometres", 1e-6},
                                    {"pm", 1e-9},
                                    {"picometer", 1e-9},
                                    {"picometre", 1e-9},
                                    {"\u00e5", 1e-7},
                                    {"\u00c5", 1e-7},
                                    {"\u212b", 1e-7},
                                    {"\xc5", 1e-7},
                                    {"angstrom", 1e-7},
                                    {"angstroms", 1e-7},
                                    {"\u00e5ngstr\u00f6m", 1e-7},
                                    {"\u00c5ngstr\u00f6m", 1e-7},
                                    {"in", 25.4},
                                    {"inch", 25.4},
                                    {"inches", 25.4},
                                    {"km", 1e6},
                                    {"thou", 0.0254},
                                    {"ft", 304.8},
                                    {"yd", 914.4}};
  const std::string lower = lower_case(trimmed(unit));
  for (const Unit& known : kUnits) {
    if (known.name == lower) return known.millimetres;
  }
  if (is_micro_metre(lower)) return 1e-3;
  return std::nullopt;
}

void to_millimetres(std::string_view unit, HeaderGeometry& geometry,
                    std::vector<std::string>& notes) {
  if (!unit.empty()) scale_lengths(millimetres_or_note(unit, notes), geometry);
}

void spacing_to_millimetres(const std::array<std::string, 3>& units, HeaderGeometry& geometry,
                            std::vector<std::string>& notes) {
  double* const spacing[] = {&geometry.spacing.x, &geometry.spacing.y, &geometry.spacing.z};
  std::vector<std::string> repeated;
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string& unit = units[axis];
    if (unit.empty() || lower_case(unit).starts_with("pixel")) continue;
    const bool is_new = axis == 0 || unit != units[axis - 1];
    *spacing[axis] *= millimetres_or_note(unit, is_new ? notes : repeated);
  }
}

}  // namespace isosplat::import
