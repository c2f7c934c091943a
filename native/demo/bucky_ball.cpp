#include <array>

#include "native/demo/demo_volumes.h"
#include "native/demo/parallel_slices.h"
#include "shared/core/base/portable_math.h"

namespace isosplat {
namespace {

constexpr double kPhi = 1.61803398874989484820;  // golden ratio

// In units in which bonds are 2 long. Wide enough to show bonds at middle isovalues, narrow enough
// to keep the pentagons and hexagons open there.
constexpr double kSigma = 0.75;

/// The even permutations, with all signs, of (0, 1, 3φ), (1, 2 + φ, 2φ) and (φ, 2, 2φ + 1).
std::array<Vec3d, 60> atoms() {
  constexpr Vec3d kSeeds[] = {{0, 1, 3 * kPhi}, {1, 2 + kPhi, 2 * kPhi}, {kPhi, 2, 2 * kPhi + 1}};
  std::array<Vec3d, 60> all;
  size_t count = 0;
  for (const Vec3d seed : kSeeds) {
    for (int signs = 0; signs < 8; ++signs) {
      if (seed.x == 0 && (signs & 1)) continue;
      const Vec3d p{signs & 1 ? -seed.x : seed.x, signs & 2 ? -seed.y : seed.y,
                    signs & 4 ? -seed.z : seed.z};
      for (const Vec3d q : {p, Vec3d{p.y, p.z, p.x}, Vec3d{p.z, p.x, p.y}}) all[count++] = q;
    }
  }
  return all;
}

}  // namespace

std::vector<uint8_t> bucky_ball(int32_t size, unsigned threads) {
  const auto centres = atoms();
  constexpr double kHalfBox = 6.6;  // the atoms lie at radius 4.96
  const double step = 2 * kHalfBox / (size - 1);

  // A Gaussian is a product over the axes, so one small table per axis gives all of them.
  const auto count = static_cast<size_t>(size);
  std::vector<double> along[3];
  for (auto& table : along) table.resize(60 * count);
  for (size_t a = 0; a < 60; ++a) {
    const double c[3] = {centres[a].x, centres[a].y, centres[a].z};
    for (int axis = 0; axis < 3; ++axis) {
      for (int32_t i = 0; i < size; ++i) {
        const double d = -kHalfBox + step * i - c[axis];
        along[axis][a * count + static_cast<size_t>(i)] =
            portable::exp(-d * d / (2 * kSigma * kSigma));
      }
    }
  }
  // The peak of an atom is 1, and its neighbours add little: this is just above the largest sum.
  constexpr double kHighest = 1.12;

  std::vector<uint8_t> values(count * count * count);
  for_each_slice(size, threads, [&](int32_t z) {
    std::vector<double> row(count);
    for (size_t y = 0; y < count; ++y) {
      std::fill(row.begin(), row.end(), 0.0);
      for (size_t a = 0; a < 60; ++a) {
        const double yz = along[1][a * count + y] * along[2][a * count + static_cast<size_t>(z)];
        if (yz < 1e-5) continue;
        const double* x_table = &along[0][a * count];
        for (size_t x = 0; x < count; ++x) row[x] += x_table[x] * yz;
      }
      uint8_t* out = &values[(static_cast<size_t>(z) * count + y) * count];
      for (size_t x = 0; x < count; ++x) {
        out[x] = static_cast<uint8_t>(std::min(255.0, row[x] / kHighest * 255.0 + 0.5));
      }
    }
  });
  return values;
}

}  // namespace isosplat
