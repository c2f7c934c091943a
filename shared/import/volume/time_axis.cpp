#include "shared/import/volume/time_axis.h"

#include <cmath>
#include <utility>

#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {
namespace {

/// Units of strangers go into documents.
constexpr size_t kMaxUnitBytes = 32;

/// Rounds to a multiple of 10⁻⁷ of the unit's power of ten.
double rounded(double value, double unit) {
  const double step = std::pow(10, std::ceil(std::log10(unit)) - 7);
  // Division by the inverse, a whole number for small steps, gives the nearest decimal fraction.
  return step < 1 ? std::round(value / step) / std::round(1 / step)
                  : std::round(value / step) * step;
}

}  // namespace

TimeAxis TimeAxis::regular(double first, double distance, int64_t steps, std::string unit) {
  if (!std::isfinite(first) || !(distance > 0) || steps < 1) return {};
  std::vector<double> values;
  const double of_header = rounded(distance, distance);
  for (int64_t i = 0; i < steps && values.size() < kMaxOffered; ++i) {
    values.push_back(rounded(first + static_cast<double>(i) * of_header, distance));
  }
  return of(std::move(values), std::move(unit));
}

TimeAxis TimeAxis::of(std::vector<double> values, std::string unit) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]) || (i > 0 && values[i] <= values[i - 1])) return {};
  }
  if (unit.size() > kMaxUnitBytes) unit.clear();
  return {std::move(values), std::move(unit)};
}

}  // namespace isosplat::import
