// Structures that are thinner than the cells of coarse levels cover about as much of the picture as
// at level 0.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "native/headless/draw_image.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::exact};

class RenderCoarseGpu : public RendererTest {
 protected:
  /// Pixels that the isosurface covers at this level.
  double covered(const TestVolume& volume, double isovalue, SplatKind kind, uint32_t level) {
    RenderSettings settings;
    settings.kind = kind;
    settings.isosurfaces = {{isovalue, {1, 1, 1}, 1}};
    renderer_->set_settings(settings);
    renderer_->set_camera(default_camera(volume.grid));
    show_volume(*renderer_, volume, isovalue, isovalue, level);
    EXPECT_TRUE(draw_image(*renderer_, 256, 256));
    const auto pixels = renderer_->read_surface().value();
    return static_cast<double>(
        std::count_if(pixels.begin(), pixels.end(), [](const auto& p) { return p.hit; }));
  }
};

/// Vessels of 3 to 4 voxels' width, along an axis and oblique.
TestVolume vessels() {
  return sampled_volume({97, 97, 97}, {1, 1, 1}, [](Vec3d p) {
    const auto tube = [&](Vec3d from, Vec3d along) {
      const Vec3d d = p - from;
      const Vec3d aside = d - along * (dot(d, along) / dot(along, along));
      return 1000 * std::exp(-0.5 * dot(aside, aside) / (1.3 * 1.3));
    };
    return std::max({tube({0, 31, 22}, {1, 0, 0}), tube({20, 0, 70}, {0.4, 1, -0.3}),
                     tube({50, 50, 0}, {-0.2, 0.3, 1})});
  });
}

TEST_F(RenderCoarseGpu, VesselsThinnerThanCellsKeepTheirArea) {
  const TestVolume volume = vessels();
  for (const SplatKind kind : kKinds) {
    const double truth = covered(volume, 350, kind, 0);
    EXPECT_GT(truth, 1000);
    for (const uint32_t level : {1u, 2u, 3u}) {
      EXPECT_NEAR(covered(volume, 350, kind, level) / truth, 1, 0.3)
          << "kind " << int(kind) << ", level " << level;
    }
  }
}

TEST_F(RenderCoarseGpu, PlatesThinnerThanCellsStayClosed) {
  // The sheet is tilted: at coarse levels, some cells are above the isovalue, and others below it.
  const TestVolume volume = sampled_volume({97, 97, 97}, {1, 1, 1}, [](Vec3d p) {
    const double d = p.y - 48 + 0.06 * (p.x - 48) + 0.1 * (p.z - 48);
    return 1000 * std::exp(-0.5 * d * d / 2);
  });
  for (const SplatKind kind : kKinds) {
    const double truth = covered(volume, 500, kind, 0);
    for (const uint32_t level : {1u, 2u, 3u}) {
      EXPECT_NEAR(covered(volume, 500, kind, level) / truth, 1, 0.12)
          << "kind " << int(kind) << ", level " << level;
    }
  }
}

}  // namespace
}  // namespace isosplat::render
