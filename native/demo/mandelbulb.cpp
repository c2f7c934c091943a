#include "native/demo/demo_volumes.h"
#include "native/demo/parallel_slices.h"
#include "shared/core/base/portable_math.h"

namespace isosplat {
namespace {

constexpr int kIterations = 12;

/// (cos θ, sin θ). Squared as a complex number, it is (cos 2θ, sin 2θ).
struct Rotation {
  double c, s;
  Rotation squared() const { return {c * c - s * s, 2 * c * s}; }
};

/// p⁸ in the Mandelbulb's spherical "multiplication": both angles times eight, the radius to the
/// eighth power. Angles are doubled three times as rotations, so that no trigonometry is needed.
Vec3d eighth_power(Vec3d p, double radius) {
  const double across = std::sqrt(p.x * p.x + p.y * p.y);
  Rotation azimuth = across > 0 ? Rotation{p.x / across, p.y / across} : Rotation{1, 0};
  Rotation polar{p.z / radius, across / radius};
  for (int i = 0; i < 3; ++i) {
    azimuth = azimuth.squared();
    polar = polar.squared();
  }
  const double r2 = radius * radius, r4 = r2 * r2, r8 = r4 * r4;
  return {r8 * polar.s * azimuth.c, r8 * polar.s * azimuth.s, r8 * polar.c};
}

/// An estimate of the distance from c to the set {p → p⁸ + c stays bounded}: r ln r / (2 |dr|)
/// (Hart, Sandin and Kauffman 1989). Zero inside.
double distance(Vec3d c) {
  Vec3d p = c;
  double derivative = 1;
  for (int i = 0; i < kIterations; ++i) {
    const double r = length(p);
    if (r > 16) return 0.5 * portable::log(r) * r / derivative;
    if (r < 1e-9) return 0;
    const double r2 = r * r;
    derivative = 8 * r2 * r2 * r2 * r * derivative + 1;
    p = eighth_power(p, r) + c;
  }
  const double r = length(p);
  return r > 2 ? 0.5 * portable::log(r) * r / derivative : 0;
}

}  // namespace

std::vector<uint8_t> mandelbulb(int32_t size, unsigned threads) {
  // The bulb's radius is about 1.2. The shells are still closed at the end of the volume.
  constexpr double kHalfBox = 1.3;
  // Quantized values are linear in the logarithm of the distance, from kFar (0) to kNear (255):
  // equal steps of the isovalue divide the distance by equal factors.
  constexpr double kFar = 0.4;
  constexpr double kNear = 0.0015;
  const double low = portable::log(kFar);
  const double per_unit = 255 / (low - portable::log(kNear));
  const double step = 2 * kHalfBox / (size - 1);

  const auto count = static_cast<size_t>(size);
  std::vector<uint8_t> values(count * count * count);
  for_each_slice(size, threads, [&](int32_t z) {
    uint8_t* out = &values[static_cast<size_t>(z) * count * count];
    for (int32_t y = 0; y < size; ++y) {
      for (int32_t x = 0; x < size; ++x) {
        const Vec3d p{-kHalfBox + step * x, -kHalfBox + step * y, -kHalfBox + step * z};
        const double d = std::max(distance(p), 1e-9);
        const double quantized = (low - portable::log(d)) * per_unit;
        *out++ = static_cast<uint8_t>(std::min(255.0, std::max(0.0, quantized)) + 0.5);
      }
    }
  });
  return values;
}

}  // namespace isosplat
