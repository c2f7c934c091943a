#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace isosplat {

/// A field with structure at all scales that fills its volume, like turbulence. It consists of
/// octaves of lattice noise, from a quarter of the volume down to eight voxels, whose amplitudes
/// are the cube root of their size (Kolmogorov's law). Below eight voxels, simulations that resolve
/// turbulence are smooth. With more voxels, the field has additional fine octaves and the same
/// coarse ones.
class Turbulence {
 public:
  /// size: voxels along each axis, a power of two, at least 32.
  explicit Turbulence(int32_t size) : size_(size) {
    for (int32_t spacing = size / 4; spacing >= 8; spacing /= 2) spacings_.push_back(spacing);
  }

  /// Writes the `size` values of the row (y, z).
  void row(int32_t y, int32_t z, double* out) const {
    for (int32_t x = 0; x < size_; ++x) out[x] = 0;
    std::vector<double> lattice;
    for (size_t octave = 0; octave < spacings_.size(); ++octave) {
      const int32_t spacing = spacings_[octave];
      const double amplitude = std::cbrt(static_cast<double>(spacing) / size_);
      between_rows(octave, y, z, lattice);
      for (int32_t x = 0; x < size_; ++x) {
        const auto cell = static_cast<size_t>(x / spacing);
        const double t = fade(static_cast<double>(x % spacing) / spacing);
        out[x] += amplitude * (lattice[cell] + t * (lattice[cell + 1] - lattice[cell]));
      }
    }
  }

 private:
  /// Rises from 0 to 1 with a continuous slope, so that lattice planes are not visible.
  static double fade(double t) { return t * t * (3 - 2 * t); }

  /// A number of [−1, 1) for a lattice point of an octave (SplitMix64 of its indices).
  static double noise(size_t octave, int32_t x, int32_t y, int32_t z) {
    uint64_t bits = octave;
    for (const int32_t index : {x, y, z}) {
      bits = (bits << 15 | bits >> 49) ^ static_cast<uint64_t>(index);
      bits += 0x9e3779b97f4a7c15u;
      bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
      bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
      bits ^= bits >> 31;
    }
    return static_cast<double>(bits >> 11) * 0x1p-52 - 1;
  }

  /// Lattice values along x, interpolated to y and z.
  void between_rows(size_t octave, int32_t y, int32_t z, std::vector<double>& lattice) const {
    const int32_t spacing = spacings_[octave];
    const int32_t j = y / spacing, k = z / spacing;
    const double u = fade(static_cast<double>(y % spacing) / spacing);
    const double v = fade(static_cast<double>(z % spacing) / spacing);
    lattice.clear();
    for (int32_t i = 0; i <= size_ / spacing; ++i) {
      const double near = std::lerp(noise(octave, i, j, k), noise(octave, i, j + 1, k), u);
      const double far = std::lerp(noise(octave, i, j, k + 1), noise(octave, i, j + 1, k + 1), u);
      lattice.push_back(std::lerp(near, far, v));
    }
  }

  int32_t size_;
  std::vector<int32_t> spacings_;
};

}  // namespace isosplat
