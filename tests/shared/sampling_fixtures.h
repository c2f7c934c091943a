#pragma once

#include <bit>
#include <cstring>
#include <random>

#include "shared/core/sampling/trilinear.h"

namespace isosplat {

/// Random cells, the same natively and as WebAssembly: the C++ standard defines the numbers of its
/// engines exactly, but not those of its distributions.
class RandomCells {
 public:
  explicit RandomCells(uint32_t seed) : engine_(seed) {}

  uint32_t integer(uint32_t below) { return static_cast<uint32_t>(engine_()) % below; }

  /// In [0, 1), a multiple of 2^-24.
  float unit() { return static_cast<float>(engine_() >> 8) * 0x1p-24f; }

  /// A cell whose least and greatest quantized values are low and low + span.
  CellCorners cell(uint32_t low, uint32_t span) {
    CellCorners corners;
    for (QuantizedValue& c : corners) c = static_cast<QuantizedValue>(low + integer(span + 1));
    const uint32_t at_low = integer(8), at_high = (at_low + 1 + integer(7)) % 8;
    corners[at_low] = static_cast<QuantizedValue>(low);
    corners[at_high] = static_cast<QuantizedValue>(low + span);
    return corners;
  }

  CellCorners cell() {
    const uint32_t span = integer(65536);
    return cell(integer(65536 - span), span);
  }

 private:
  std::mt19937 engine_;
};

/// FNV-1a over the bits of a test's results, to compare builds.
class Digest {
 public:
  template <class T>
  void add(const T& value) {
    uint8_t bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    for (const uint8_t b : bytes) hash_ = (hash_ ^ b) * 1099511628211u;
  }
  void add(Vec3f v) { add(v.x), add(v.y), add(v.z); }
  uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = 14695981039346656037u;
};

/// The trilinear interpolant by its definition, in double precision.
inline double interpolate(const std::array<float, 8>& corner, double x, double y, double z) {
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    sum += corner[i] * (i & 1 ? x : 1 - x) * (i & 2 ? y : 1 - y) * (i & 4 ? z : 1 - z);
  }
  return sum;
}

}  // namespace isosplat
