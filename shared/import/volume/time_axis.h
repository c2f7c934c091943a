#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isosplat::import {

/// The times of a volume's steps, as far as its header states them.
struct TimeAxis {
  std::vector<double> values;  ///< of each step, finite and ascending; empty: not stated
  std::string unit;            ///< "s", "ms", …, or the header's word; may be empty

  /// Steps at equal distances, from `first` on. A distance that is not above 0, or not finite,
  /// states nothing, as in many headers. Times are rounded to seven digits, those of headers in
  /// single precision, so that 0.1 · 3 is 0.3.
  static TimeAxis regular(double first, double distance, int64_t steps, std::string unit);

  /// The times of steps in order. States nothing if they do not ascend.
  static TimeAxis of(std::vector<double> values, std::string unit);
};

}  // namespace isosplat::import
