// How smooth the surfaces of labels are.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/shared/test_labels.h"

namespace isosplat {
namespace {

using test::crossing;
using test::TestLabels;

/// The root mean square of the angles between a sloped sheet and the gradients of its field, in
/// degrees: at each crossing of an edge, that of the trilinear field of the cells around its ends.
/// `thickness`: in voxels; a large one gives a plane.
double roughness(double slope, double thickness = 1000) {
  TestLabels volume(72);
  const Vec3<double> normal{-slope, -0.37 * slope, 1};
  volume.add(1, [&](double x, double y, double z) {
    const double above = dot(normal, {x - 36, y - 36, z - 36.3}) / std::sqrt(dot(normal, normal));
    return above < 0 && above > -thickness;
  });
  const std::vector<std::uint8_t> field = volume.field(1);
  const auto gradient = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    Vec3<double> sum{};
    for (int i = 0; i < 8; ++i) {
      // The cells around the voxel. Only cells that the surface crosses count.
      const std::uint32_t cx = x - (i & 1), cy = y - (i >> 1 & 1), cz = z - (i >> 2);
      int inside = 0;
      for (std::uint32_t k = 0; k < 8; ++k)
        inside += field[volume.at(cx + (k & 1U), cy + (k >> 1U & 1U), cz + (k >> 2U))] >
                          kLabelFieldIsovalue
                      ? 1
                      : 0;
      if (inside == 0 || inside == 8) continue;
      sum.x += field[volume.at(cx + 1, y, z)] - field[volume.at(cx, y, z)];
      sum.y += field[volume.at(x, cy + 1, z)] - field[volume.at(x, cy, z)];
      sum.z += field[volume.at(x, y, cz + 1)] - field[volume.at(x, y, cz)];
    }
    return sum;
  };
  double squares = 0;
  int crossings = 0;
  for (std::uint32_t y = 20; y < 52; ++y)
    for (std::uint32_t x = 20; x < 52; ++x)
      for (std::uint32_t z = 8; z < 64; ++z) {
        const int low = field[volume.at(x, y, z)];
        const int high = field[volume.at(x, y, z + 1)];
        if ((low > kLabelFieldIsovalue) == (high > kLabelFieldIsovalue)) continue;
        const double part = crossing(low, high);
        const Vec3<double> a = gradient(x, y, z);
        const Vec3<double> b = gradient(x, y, z + 1);
        const Vec3<double> g{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y),
                             a.z + part * (b.z - a.z)};
        const int side = high > low ? 1 : -1;
        const double cosine = side * dot(g, normal) / std::sqrt(dot(g, g) * dot(normal, normal));
        const double degrees = std::acos(std::min(cosine, 1.0)) * 180 / std::acos(-1.0);
        squares += degrees * degrees;
        ++crossings;
      }
  return std::sqrt(squares / crossings);
}

/// Without smoothing along the border, stairs give 10 to 16 degrees.
TEST(LabelSmoothness, SlopedPlanesAreFlat) {
  for (const double voxels : {4.3, 7.7, 12.0}) EXPECT_LT(roughness(1 / voxels), 2) << voxels;
  for (const double voxels : {20.0, 30.0}) EXPECT_LT(roughness(1 / voxels), 3.7) << voxels;
}

/// In thin sheets, the limits of the voxels' sides leave little room for a smooth surface.
TEST(LabelSmoothness, ThinSheetsAreSmooth) {
  for (const double voxels : {4.3, 7.7, 12.0}) {
    EXPECT_LT(roughness(1 / voxels, 2.4), 4) << voxels;
    EXPECT_LT(roughness(1 / voxels, 4), 2) << voxels;
  }
  EXPECT_LT(roughness(1 / 20.0, 2.4), 4.6);
  EXPECT_LT(roughness(1 / 20.0, 4), 3);
}

}  // namespace
}  // namespace isosplat
