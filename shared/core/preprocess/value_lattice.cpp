#include "shared/core/preprocess/value_lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

namespace isosplat {
namespace {

/// Half the distance to the next number of the type: the greatest rounding error.
double half_ulp(double value, bool is_single) {
  const double size = std::abs(value);
  if (!is_single) return (std::nextafter(size, HUGE_VAL) - size) / 2;
  const auto single = static_cast<float>(size);
  return (static_cast<double>(std::nextafter(single, HUGE_VALF)) - static_cast<double>(single)) / 2;
}

/// The values, and the number n of the lattice point of each, once it is known.
struct Fit {
  std::span<const double> values;
  bool is_single;
  uint32_t max_steps;
  std::vector<double> roundings;  ///< half_ulp() of each value
  std::vector<double> numbers;
};

/// The greatest distance of a value from its lattice point; infinity if a value is nearer to
/// another lattice point.
double error_of(const Fit& fit, double origin, double step) {
  if (!(step > 0) || !std::isfinite(step) || !std::isfinite(origin)) return HUGE_VAL;
  double most = 0;
  for (size_t i = 0; i < fit.values.size(); ++i) {
    const double exact = origin + step * fit.numbers[i];
    const double point = fit.is_single ? static_cast<double>(static_cast<float>(exact)) : exact;
    // The same formula as in Quantization::quantize().
    if (std::floor((fit.values[i] - origin) / step + 0.5) != fit.numbers[i]) return HUGE_VAL;
    most = std::max(most, std::abs(point - fit.values[i]));
  }
  return most;
}

/// The greatest step of which all differences are multiples, by Euclid's algorithm; 0 if it is
/// smaller than `least`. fmod is exact, and so are differences of a lattice with few steps.
double exact_step(std::span<const double> values, double least) {
  double step = 0;
  for (const double value : values) {
    double other = value - values.front();
    while (other > 0) {
      step = std::fmod(step, other);
      std::swap(step, other);
      if (step < least) return 0;
    }
  }
  return step;
}

/// Assigns lattice points to the values, for a step near `step`. Begins at value `start` and
/// proceeds outwards, the nearer value first; the wider the range covered, the better the step is
/// known. A value may be off its lattice point by twice its rounding error (or that of the largest
/// value, if of_largest). Returns 1 if all values have lattice points; a divisor for the step if a
/// value lies between two lattice points; 0 if there is no such lattice.
double number_values(Fit& fit, size_t start, double step, bool of_largest) {
  const std::span<const double> values = fit.values;
  const double largest = std::max(fit.roundings.front(), fit.roundings.back());
  const auto slack = [&](size_t i) { return 2 * (of_largest ? largest : fit.roundings[i]); };
  size_t low = start, high = start;
  double step_error = 4 * largest;
  fit.numbers[start] = 0;
  while (high - low + 1 < values.size()) {
    const double below = low > 0 ? values[low] - values[low - 1] : HUGE_VAL;
    const double above = high + 1 < values.size() ? values[high + 1] - values[high] : HUGE_VAL;
    const bool is_up = above <= below;
    const size_t from = is_up ? high : low, to = is_up ? high + 1 : low - 1;
    const double gap = std::min(above, below);
    const double steps = std::floor(gap / step + 0.5);
    const double allowed = slack(from) + slack(to) + std::max(steps, 1.0) * step_error;
    if (!(allowed < step / 4)) return 0;
    if (const double rest = std::abs(gap - steps * step); rest > allowed) {
      const double most = fit.max_steps * step / (values.back() - values.front());
      for (double divisor = 2; divisor <= most; ++divisor) {
        const double part = rest * divisor / step;
        if (std::abs(part - std::floor(part + 0.5)) <= allowed * divisor / step) return divisor;
      }
      return 0;
    }
    fit.numbers[to] = fit.numbers[from] + (is_up ? steps : -steps);
    (is_up ? high : low) = to;
    const double number = fit.numbers[high] - fit.numbers[low];
    if (const double known = (slack(low) + slack(high)) / number; known < step_error) {
      step = (values[high] - values[low]) / number;
      step_error = known;
    }
  }
  const double first = fit.numbers.front();
  for (double& number : fit.numbers) number -= first;
  return fit.numbers.back() <= fit.max_steps ? 1 : 0;
}

/// Finds a lattice on which the values lie up to rounding, and assigns its points to them.
bool find_numbers(Fit& fit) {
  const std::span<const double> values = fit.values;
  size_t start = 0;
  double least = HUGE_VAL;
  for (size_t i = 0; i + 1 < values.size(); ++i) {
    if (values[i + 1] - values[i] >= least) continue;
    least = values[i + 1] - values[i];
    start = i;
  }
  if (least * fit.max_steps < (values.back() - values.front()) / 2) return false;
  fit.numbers.assign(values.size(), 0);
  // Values that were computed in single precision carry rounding errors of larger intermediate
  // results. So the second attempt allows each value the error of the largest one.
  for (const bool of_largest : {false, true}) {
    double step = least;
    for (int attempt = 0; attempt < 17; ++attempt) {
      const double divisor = number_values(fit, start, step, of_largest);
      if (divisor == 1) return true;
      if (divisor == 0) break;
      step /= divisor;
    }
  }
  return false;
}

struct Interval {
  long double low, high;
};

/// The origins for which, with this step, the distance of each value from its lattice point is
/// within its rounding error. None if low > high.
Interval origins(const Fit& fit, long double step) {
  Interval interval{-HUGE_VALL, HUGE_VALL};
  for (size_t i = 0; i < fit.values.size(); ++i) {
    const long double origin = fit.values[i] - step * fit.numbers[i];
    const long double rounding = fit.roundings[i];
    interval.low = std::max(interval.low, origin - rounding);
    interval.high = std::min(interval.high, origin + rounding);
  }
  return interval;
}

/// The steps for which there is such an origin; if there is none for any step, the step that comes
/// closest. The width of the interval of origins is a concave function of the step: ternary search
/// finds its maximum, bisection its zeros.
Interval steps(const Fit& fit) {
  const auto room = [&](long double step) {
    const Interval interval = origins(fit, step);
    return interval.high - interval.low;
  };
  const long double number = fit.numbers.back();
  const long double middle =
      (static_cast<long double>(fit.values.back()) - fit.values.front()) / number;
  const long double reach = 4 * (fit.roundings.back() + fit.roundings.front()) / number;
  constexpr int kHalvings = 40;
  Interval around{middle - reach, middle + reach};
  for (int i = 0; i < kHalvings; ++i) {
    const long double third = (around.high - around.low) / 3;
    if (room(around.low + third) < room(around.high - third)) {
      around.low += third;
    } else {
      around.high -= third;
    }
  }
  const long double best = (around.low + around.high) / 2;
  if (room(best) < 0) return {best, best};
  const auto bound = [&](long double inside, long double outside) {
    for (int i = 0; i < kHalvings; ++i) {
      const long double half = (inside + outside) / 2;
      (room(half) >= 0 ? inside : outside) = half;
    }
    return inside;
  };
  return {bound(best, middle - 2 * reach), bound(best, middle + 2 * reach)};
}

/// The number of an interval with the fewest decimal digits, near its middle.
double shortest(Interval interval) {
  const auto middle = static_cast<double>((interval.low + interval.high) / 2);
  for (int digits = 1; digits < 17; ++digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", digits, middle);
    const double number = std::strtod(text, nullptr);
    if (number >= interval.low && number <= interval.high) return number;
  }
  return middle;
}

}  // namespace

std::optional<ValueLattice> find_lattice(std::span<const double> values, bool is_single,
                                         uint32_t max_steps) {
  if (values.empty()) return std::nullopt;
  if (values.size() == 1) return ValueLattice{values[0], 1, 0, 0};
  Fit fit{values, is_single, max_steps, {}, {}};
  for (const double value : values) fit.roundings.push_back(half_ulp(value, is_single));
  const double range = values.back() - values.front();
  ValueLattice best;
  best.max_error = HUGE_VAL;
  const auto consider = [&](double origin, double step) {
    if (best.max_error == 0) return;
    const double error = error_of(fit, origin, step);
    if (error >= best.max_error) return;
    best = {origin, step, static_cast<uint32_t>(fit.numbers.back()), error};
  };

  if (const double step = exact_step(values, range / max_steps * (1 - 1e-12)); step > 0) {
    for (const double value : values) {
      fit.numbers.push_back(std::floor((value - values.front()) / step + 0.5));
    }
    if (fit.numbers.back() <= max_steps) consider(values.front(), step);
    if (best.max_error == 0) return best;
  }
  if (!find_numbers(fit)) return std::nullopt;

  // Among the steps and origins that are possible, short decimal numbers are most likely the
  // original ones, and the middle is the safest.
  const Interval range_of_steps = steps(fit);
  const auto middle = static_cast<double>((range_of_steps.low + range_of_steps.high) / 2);
  for (const double step : {shortest(range_of_steps), middle}) {
    const Interval range_of_origins = origins(fit, step);
    consider(shortest(range_of_origins), step);
    consider(static_cast<double>((range_of_origins.low + range_of_origins.high) / 2), step);
  }
  consider(values.front(), range / fit.numbers.back());
  // Values that were computed as n · step, without an origin: with the origin 0 they are reproduced
  // by the same computation.
  const double step = shortest(range_of_steps);
  const double before = std::floor(values.front() / step + 0.5);
  const double last = before + fit.numbers.back();
  if (before > 0 && last <= max_steps && (last < 256 || fit.numbers.back() >= 256)) {
    for (double& number : fit.numbers) number += before;
    consider(0, step);
  }
  // A greater error is not rounding; the values match by chance, and 65535 even steps are as exact.
  if (best.max_error > std::min(best.step / 64, range / 131072)) return std::nullopt;
  return best;
}

}  // namespace isosplat
