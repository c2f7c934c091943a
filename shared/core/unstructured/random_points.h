#pragma once

#include <cstdint>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// Random numbers that are the same on each machine (splitmix64; Steele et al. 2014).
class RandomPoints {
 public:
  explicit RandomPoints(uint64_t seed) : state_(seed) {}

  /// From 0, below 1.
  double number() {
    state_ += 0x9e3779b97f4a7c15u;
    uint64_t z = state_;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
  }
  Vec3d in_unit_cube() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }

 private:
  uint64_t state_;
};

}  // namespace isosplat
