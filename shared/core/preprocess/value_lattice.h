#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace isosplat {

/// Evenly spaced values: origin + step · n for n from 0 to steps, computed in double precision.
struct ValueLattice {
  double origin = 0;
  double step = 1;  ///< above 0
  uint32_t steps = 0;
  /// The greatest difference between a value and its lattice point, rounded to the values' type; 0
  /// if all are equal bit for bit.
  double max_error = 0;
};

/// Finds the coarsest lattice on which floating-point values lie. Examples: integers or labels in a
/// file of floats, multiples of 0.1, integers that were multiplied by a slope and rounded.
///
/// values: distinct, ascending, within ±1e300. is_single: they are single-precision numbers.
/// max_steps: 1 to 65535. Returns nullopt if there is no lattice with at most max_steps steps, or
/// none whose points are much closer to the values than half a step.
///
/// The function verifies the result with each value. max_error can be above 0, because rounding to
/// the type moves values off the lattice. Takes at most a few hundred passes over the values.
std::optional<ValueLattice> find_lattice(std::span<const double> values, bool is_single,
                                         uint32_t max_steps);

}  // namespace isosplat
