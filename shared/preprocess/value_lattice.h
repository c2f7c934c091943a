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
  /// No value differs by more from its place, after rounding to the values' own type; 0: each is
  /// there to the bit.
  double max_error = 0;
};

/// Finds the coarsest lattice that a file's floating-point numbers lie on: integers in a float
/// file, labels, multiples of 0.1, integers that were multiplied by a slope and rounded.
///
/// `values`: all distinct ones, ascending, finite, of at most ±1e300. `is_single`: they are
/// single-precision numbers. `max_steps`: 1 to 65535. Nothing where there is no lattice with so
/// few steps, or none that is much closer to the values than half a step.
///
/// The result is verified for each of the values: rounding to the type may move values away from an
/// even lattice, and what can be had then is max_error. Takes a few hundred passes over the values
/// at most.
std::optional<ValueLattice> find_lattice(std::span<const double> values, bool is_single,
                                         uint32_t max_steps);

}  // namespace isosplat
