#include "shared/preprocess/value_lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

namespace isosplat {
namespace {

/// Half the distance to the next number of the type: how far rounding to it may move a value.
double half_ulp(double value, bool is_single) {
  const double size = std::abs(value);
  if (!is_single) return (std::nextafter(size, HUGE_VAL) - size) / 2;
  const auto single = static_cast<float>(size);
  return (static_cast<double>(std::nextafter(single, HUGE_VALF)) - static_cast<double>(single)) / 2;
}

/// The problem: values, and for each its number on a lattice, once that is known.
struct Fit {
  std::span<const double> values;
  bool is_single;
  uint32_t max_steps;
  std::vector<double> roundings;  ///< half_ulp of each
  std::vector<double> numbers;
};

/// How far the values are from their places; infinity where a value would be nearer to another
/// place.
double error_of(const Fit& fit, double origin, double step) {
  if (!(step > 0) || !std::isfinite(step) || !std::isfinite(origin)) return HUGE_VAL;
  double most = 0;
  for (size_t i = 0; i < fit.values.size(); ++i) {
    const double exact = origin + step * fit.numbers[i];
    const double place = fit.is_single ? static_cast<double>(static_cast<float>(exact)) : exact;
    // As the encoder does it.
    if (std::floor((fit.values[i] - origin) / step + 0.5) != fit.numbers[i]) return HUGE_VAL;
    most = std::max(most, std::abs(place - fit.values[i]));
  }
  return most;
}

/// The greatest step of which all differences are whole multiples, by Euclid's algorithm; 0 where
/// it is smaller than `least`. fmod is exact, and so are differences of a lattice with few steps.
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

/// Numbers the values along the lattice whose step is near `step`: from two neighbours outwards,
/// the nearer value first, while the step becomes known better and better. Values are where they
/// should be within twice their rounding, or that of the largest. Returns what to divide the step
/// by where a value lies between two places, 1 where all have their numbers, 0 where there is no
/// such lattice.
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
    const double places = std::floor(gap / step + 0.5);
    const double allowed = slack(from) + slack(to) + std::max(places, 1.0) * step_error;
    if (!(allowed < step / 4)) return 0;
    if (const double rest = std::abs(gap - places * step); rest > allowed) {
      const double most = fit.max_steps * step / (values.back() - values.front());
      for (double divisor = 2; divisor <= most; ++divisor) {
        const double part = rest * divisor / step;
        if (std::abs(part - std::floor(part + 0.5)) <= allowed * divisor / step) return divisor;
      }
      return 0;
    }
    fit.numbers[to] = fit.numbers[from] + (is_up ? places : -places);
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

/// Gives the values their numbers on a lattice that they lie on up to rounding.
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
  // A value that was computed in single precision carries the rounding of larger intermediate
  // results: then each may be off by as much as the largest.
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

/// The origins for which, with this step, each value is within its rounding of its place: from low
/// to high, none where low is above.
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

/// The steps for which there is an origin; where there is none, only the step that comes nearest.
/// The room for the origin is a concave function of the step, so that bisection finds its maximum
/// (by slope) and its zeros.
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

  // Of all steps and origins that round to the values, decimal ones are likely those that the
  // values were made of, and the middle is the safest.
  const Interval range_of_steps = steps(fit);
  const auto middle = static_cast<double>((range_of_steps.low + range_of_steps.high) / 2);
  for (const double step : {shortest(range_of_steps), middle}) {
    const Interval range_of_origins = origins(fit, step);
    consider(shortest(range_of_origins), step);
    consider(static_cast<double>((range_of_origins.low + range_of_origins.high) / 2), step);
  }
  consider(values.front(), range / fit.numbers.back());
  // Multiples of a step were multiplied, and not added to anything: as numbers from 0 on they are
  // computed in the same way.
  const double step = shortest(range_of_steps);
  const double before = std::floor(values.front() / step + 0.5);
  const double last = before + fit.numbers.back();
  if (before > 0 && last <= max_steps && (last < 256 || fit.numbers.back() >= 256)) {
    for (double& number : fit.numbers) number += before;
    consider(0, step);
  }
  // Beyond that it is no rounding, but chance; and 16 bits can do better.
  if (best.max_error > std::min(best.step / 64, range / 131072)) return std::nullopt;
  return best;
}

}  // namespace isosplat
