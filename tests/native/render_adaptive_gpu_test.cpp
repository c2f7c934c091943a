// Pictures of an adaptive grid as a scene of its refinement levels, compared with a ray caster over
// the function of its leaf cells on a uniform grid. Thresholds are stated at each comparison.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "native/headless/ray_caster.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"
#include "tests/shared/blast_wave.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 400;
constexpr double kIsovalue = 2.2;
constexpr double kDegrees = 180 / 3.14159265358979323846;

/// The values of all levels fit.
constexpr double kLow = -1, kHigh = 6;

QuantizedValue quantized(double value) {
  if (!std::isfinite(value)) return kMissingVoxel;
  return static_cast<QuantizedValue>(std::lround((value - kLow) / (kHigh - kLow) * 65534));
}

ValueMapping mapping() {
  ValueMapping made;
  made.offset = kLow;
  made.scale = (kHigh - kLow) / 65534;
  made.has_missing = true;
  return made;
}

class AdaptiveGpu : public RendererTest {
 protected:
  void prepare() override {
    made_ = adaptive_test::blast_wave(3);
    auto grid = adaptive_test::make_grid(made_);
    ASSERT_TRUE(grid) << grid.error().message;
    VolumeHeader header;
    header.grid.origin = {-1, -1, -1};
    header.grid.spacing = {0.0625, 0.0625, 0.0625};
    for (uint32_t level = 0; level < grid->levels(); ++level) {
      auto source = LevelSource::create(*grid, level, header);
      ASSERT_TRUE(source);
      TestVolume volume;
      volume.grid = source->header().grid;
      volume.mapping = mapping();
      std::vector<double> values(adaptive_test::volume(volume.grid.voxels));
      ASSERT_TRUE(
          source->read_slices(0, volume.grid.voxels.z, std::as_writable_bytes(std::span(values))));
      for (const double value : values) volume.quantized_values.push_back(quantized(value));
      levels_.push_back(std::move(volume));
    }
    camera_ = default_camera(uniform_grid());
    camera_.distance *= 0.55;
    camera_.azimuth = 0;  // the levels are beside each other
  }

  /// All nodes of the finest level.
  VolumeGrid uniform_grid() const {
    VolumeGrid grid;
    const int32_t cells = 32 * made_.edge(0, made_.ratios.size());
    grid.voxels = {cells + 1, cells + 1, cells + 1};
    grid.origin = {-1, -1, -1};
    grid.spacing = {2.0 / cells, 2.0 / cells, 2.0 / cells};
    return grid;
  }

  /// The function of the leaf cells at these nodes, by brute force.
  TestVolume uniform() const {
    const adaptive_test::BruteForce brute(made_);
    TestVolume volume;
    volume.grid = uniform_grid();
    volume.mapping = mapping();
    const Index3 last = volume.grid.voxels - Index3{2, 2, 2};
    adaptive_test::for_each_index(volume.grid.voxels, [&](Index3 node) {
      const Index3 cell{std::min(node.x, last.x), std::min(node.y, last.y),
                        std::min(node.z, last.z)};
      const Vec3d point{node.x * 1.0, node.y * 1.0, node.z * 1.0};
      volume.quantized_values.push_back(quantized(brute.in_cell(*brute.leaf(cell), point)));
    });
    return volume;
  }

  /// Draws the levels as volumes 0, 1, ….
  std::vector<SurfacePixel> draw(Shading shading, const std::string& name) {
    RenderSettings settings;
    settings.kind = SplatKind::exact;
    settings.shading = shading;
    for (size_t i = 0; i < levels_.size(); ++i) {
      const auto id = static_cast<VolumeId>(i);
      settings.isosurfaces.push_back({kIsovalue, {0.9f, 0.85f, 0.74f}, 1, id});
      show_volume(*renderer_, levels_[i], kIsovalue, kIsovalue, 0, id);
    }
    draw_and_keep(settings, camera_, kSize, name);
    return *renderer_->read_surface();
  }

  Vec3d world(const Vec3f& normal) const {
    const CameraFrame frame = camera_frame(camera_);
    return frame.right * double(normal.x) + frame.up * double(normal.y) -
           frame.forward * double(normal.z);
  }

  adaptive_test::Case made_;
  std::vector<TestVolume> levels_;
  Camera camera_;
};

/// How a picture differs from the ray caster.
struct Differences {
  int hits = 0;
  int coverage = 0;  ///< pixels that only one of both covers
  int depth = 0;     ///< pixels whose depths differ by more than 0.1 cells of the finest level
};

TEST_F(AdaptiveGpu, PicturesOfLevelsEqualThatOfTheirFunction) {
  const auto pixels = draw(Shading::exact, "adaptive");
  const TestVolume truth = uniform();
  const RayCaster caster(truth.grid, truth.quantized_values, true);
  const double cell = truth.grid.spacing.x;
  const auto at = [&](int x, int y) -> const SurfacePixel& {
    return pixels[size_t(y) * kSize + size_t(x)];
  };
  // Whether the surfaces of two levels are seen within two pixels.
  const auto is_on_border = [&](int x, int y) {
    std::set<uint32_t> levels;
    for (int j = std::max(0, y - 2); j <= std::min(kSize - 1, y + 2); ++j) {
      for (int i = std::max(0, x - 2); i <= std::min(kSize - 1, x + 2); ++i) {
        if (at(i, j).hit) levels.insert(at(i, j).isosurface);
      }
    }
    return levels.size() > 1;
  };
  Differences border, inside;
  std::vector<int> seen(levels_.size());
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const SurfacePixel& pixel = at(x, y);
      const auto hit =
          caster.cast(camera_, kSize, kSize, x, y, truth.mapping.quantized_isovalue(kIsovalue));
      Differences& here = is_on_border(x, y) ? border : inside;
      here.coverage += hit.has_value() != pixel.hit;
      if (!hit || !pixel.hit) continue;
      ++here.hits;
      ++seen[pixel.isosurface];
      here.depth += std::abs(hit->depth - double(pixel.depth)) > 0.1 * cell;
    }
  }
  std::printf("pixels, other coverage, other depth: border %d %d %d, inside %d %d %d\n",
              border.hits, border.coverage, border.depth, inside.hits, inside.coverage,
              inside.depth);
  for (const int count : seen) EXPECT_GT(count, 2000) << "each level is to be seen";
  EXPECT_GT(border.hits, 1000);
  EXPECT_EQ(border.coverage, 0);
  EXPECT_EQ(border.depth, 0);
  // Silhouettes, and rays that touch the surface.
  EXPECT_LE(inside.coverage, inside.hits / 2000);
  EXPECT_LE(inside.depth, inside.hits / 2000);
}

/// A cell whose neighbours are in another store has a normal of its own side there. The angle
/// between the normals of neighbouring pixels is compared on the borders of levels and elsewhere.
TEST_F(AdaptiveGpu, SmoothNormalsTurnLittleOnBordersOfLevels) {
  const auto pixels = draw(Shading::smooth, "adaptive-smooth");
  std::vector<double> border, inside;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x + 1 < kSize; ++x) {
      const SurfacePixel& a = pixels[size_t(y) * kSize + size_t(x)];
      const SurfacePixel& b = pixels[size_t(y) * kSize + size_t(x) + 1];
      if (!a.hit || !b.hit || std::abs(a.depth - b.depth) > 0.05f) continue;
      const Vec3d u = world(a.normal), v = world(b.normal);
      const double angle = std::atan2(length(cross(u, v)), dot(u, v)) * kDegrees;
      (a.isosurface == b.isosurface ? inside : border).push_back(angle);
    }
  }
  ASSERT_GT(border.size(), 300u);
  const auto at = [](std::vector<double>& angles, double share) {
    std::sort(angles.begin(), angles.end());
    return angles[static_cast<size_t>(share * static_cast<double>(angles.size() - 1))];
  };
  std::printf(
      "normals of neighbouring pixels, degrees (median, 95 %%): border %.2f %.2f, inside %.2f "
      "%.2f\n",
      at(border, 0.5), at(border, 0.95), at(inside, 0.5), at(inside, 0.95));
  EXPECT_LT(at(border, 0.95), 20);
}

}  // namespace
}  // namespace isosplat::render
