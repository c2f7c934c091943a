#include "shared/import/conventions.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "shared/import/header_text.h"

namespace isosplat {
namespace {

void negate_row(size_t row, HeaderGeometry& geometry) {
  double* const origin[] = {&geometry.origin.x, &geometry.origin.y, &geometry.origin.z};
  *origin[row] = 0 - *origin[row];
  for (size_t axis = 0; axis < 3; ++axis) {
    geometry.direction[3 * row + axis] = 0 - geometry.direction[3 * row + axis];
  }
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
    // Exactly 0 for right angles.
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
                                    {"um", 1e-3},
                                    {"\u00b5m", 1e-3},
                                    {"\u03bcm", 1e-3},
                                    {"\\u00b5m", 1e-3},
                                    {"\xb5m", 1e-3},
                                    {"micron", 1e-3},
                                    {"microns", 1e-3},
                                    {"micrometer", 1e-3},
                                    {"micrometre", 1e-3},
                                    {"micrometers", 1e-3},
                                    {"micrometres", 1e-3},
                                    {"nm", 1e-6},
                                    {"nanometer", 1e-6},
                                    {"nanometre", 1e-6},
                                    {"in", 25.4},
                                    {"inch", 25.4},
                                    {"inches", 25.4},
                                    {"km", 1e6},
                                    {"ft", 304.8}};
  const std::string lower = lower_case(trimmed(unit));
  for (const Unit& known : kUnits) {
    if (known.name == lower) return known.millimetres;
  }
  return std::nullopt;
}

void to_millimetres(std::string_view unit, HeaderGeometry& geometry,
                    std::vector<std::string>& notes) {
  if (unit.empty()) return;
  if (const auto factor = millimetres_in(unit)) {
    scale_lengths(*factor, geometry);
  } else {
    notes.push_back(
        fmt::format("lengths are in the unknown unit '{}': they are read as millimetres", unit));
  }
}

void spacing_to_millimetres(const std::array<std::string, 3>& units, HeaderGeometry& geometry,
                            std::vector<std::string>& notes) {
  double* const spacing[] = {&geometry.spacing.x, &geometry.spacing.y, &geometry.spacing.z};
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string& unit = units[axis];
    if (unit.empty() || lower_case(unit).starts_with("pixel")) continue;
    if (const auto factor = millimetres_in(unit)) {
      *spacing[axis] *= *factor;
    } else if (axis == 0 || unit != units[axis - 1]) {
      notes.push_back(
          fmt::format("lengths are in the unknown unit '{}': they are read as millimetres", unit));
    }
  }
}

}  // namespace isosplat
