#include "shared/import/volume/time_axis.h"

#include <cmath>
#include <utility>

#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {
namespace {

/// Units come from strangers, and are copied to documents.
constexpr size_t kMaxUnitBytes = 32;

/// Rounds to seven digits of `unit`. Only powers of ten up to 10²² are exact, so units below 10⁻¹⁵
/// and above 10¹⁵ are left as they are.
double rounded(double value, double unit) {
  if (!(unit >= 1e-15 && unit <= 1e15)) return value;
  double power = 1, inverse = 1;
  while (power < unit) power *= 10;
  while (unit * inverse * 10 <= 1) inverse *= 10;
  const double scale = 1e7 * inverse;
  if (power <= scale) return std::round(value * (scale / power)) / (scale / power);
  return std::round(value / (power / scale)) * (power / scale);
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
