// Compares the results of occlusion queries with the pixels of the picture.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "native/headless/draw_image.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr uint32_t kLevel = 1;

class OcclusionQueryGpu : public RendererTest {
 protected:
  void prepare() override {
    volume_ = sphere_volume({129, 129, 129});
    settings_.kind = SplatKind::exact;
    settings_.isosurfaces = {{5000, {1, 1, 1}, 1}};
    renderer_->set_camera(default_camera(volume_.grid, double(kWidth) / kHeight));
  }

  /// Draws level 1, a single block, and runs an occlusion query.
  ChunkVisibility visibility(int min_px) {
    show_volume(*renderer_, volume_, 3000, 5000, kLevel);
    renderer_->set_settings(settings_);
    EXPECT_TRUE(draw_image(*renderer_, kWidth, kHeight));
    const ChunkHandle handle = 0;
    EXPECT_TRUE(renderer_->begin_occlusion_query({&handle, 1}, min_px));
    glFinish();
    const auto answer = renderer_->take_occlusion_query();
    EXPECT_FALSE(renderer_->take_occlusion_query());
    if (!answer || answer->size() != 1) {
      ADD_FAILURE() << "expected the result of a query for one chunk";
      return {};
    }
    return answer->at(0);
  }

  /// Pixels that show the opaque surface in each region.
  std::map<int, int> pixels_of_regions() {
    const auto pixels = renderer_->read_surface().value();
    const CameraFrame frame = camera_frame(renderer_->camera());
    std::map<int, int> counts;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      if (!pixels[size_t(i)].hit) continue;
      const double scale = frame.tan_half_field_of_view * 2 / kHeight;
      const double x = (i % kWidth + 0.5 - 0.5 * kWidth) * scale;
      const double y = (i / kWidth + 0.5 - 0.5 * kHeight) * scale;
      const Vec3d p =
          frame.eye + (frame.forward + frame.right * x + frame.up * y) * pixels[size_t(i)].depth;
      const auto region = [](double at) { return static_cast<int>(at / (8 << kLevel)); };
      ++counts[region(p.x) + 8 * region(p.y) + 64 * region(p.z)];
    }
    return counts;
  }

  TestVolume volume_;
  RenderSettings settings_;
};

TEST_F(OcclusionQueryGpu, RegionsWithEnoughPixelsAreVisible) {
  constexpr int kMin = 40;
  const ChunkVisibility answer = visibility(kMin);
  EXPECT_EQ(answer.tested, RegionMask::all());
  auto counts = pixels_of_regions();
  int seen = 0, hidden = 0;
  for (int bit = 0; bit < 512; ++bit) {
    const bool is_seen = answer.visible.contains({bit % 8, bit / 8 % 8, bit / 64});
    // Cells are 2 to 3 px wide. A pixel within 1/4 px of the boundary of two cells counts for both.
    if (is_seen) {
      EXPECT_GE(counts[bit], kMin / 2) << "region " << bit;
    } else {
      EXPECT_LE(counts[bit], kMin * 5 / 4) << "region " << bit;
    }
    ++(is_seen ? seen : hidden);
  }
  EXPECT_GT(seen, 20);
  EXPECT_GT(hidden, 300);
}

TEST_F(OcclusionQueryGpu, AMinimumOfZeroPixelsAlsoCountsRegionsBetweenPixels) {
  const ChunkVisibility shown = visibility(1);
  const ChunkVisibility answer = visibility(0);
  EXPECT_EQ(answer.tested, RegionMask::all());
  auto counts = pixels_of_regions();
  int seen = 0, more = 0;
  for (int bit = 0; bit < 512; ++bit) {
    const Index3 region{bit % 8, bit / 8 % 8, bit / 64};
    if (answer.visible.contains(region)) ++seen;
    // At the outline, cells of the hidden half project beyond the visible surface.
    if (answer.visible.contains(region) && !shown.visible.contains(region)) ++more;
    if (counts[bit] > 40) {
      EXPECT_TRUE(answer.visible.contains(region)) << "region " << bit;
    }
  }
  EXPECT_GT(more, 0);
  EXPECT_LT(seen, 250);
}

TEST_F(OcclusionQueryGpu, AnOpaqueSurfaceHidesRegionsBehindItForAMinimumOfZeroPixels) {
  // A sphere of radius 30 inside of an opaque one.
  settings_.isosurfaces = {{5000, {1, 1, 1}, 1}};
  const RegionMask outer = visibility(0).visible;
  settings_.isosurfaces.push_back({3000, {1, 0, 0}, 1});
  EXPECT_EQ(visibility(0).visible, outer);
  settings_.isosurfaces[0].opacity = 0.5f;
  EXPECT_NE(visibility(0).visible, outer);
}

TEST_F(OcclusionQueryGpu, AnInnerSurfaceIsVisibleThroughATranslucentSurfaceOnly) {
  // No region contains cells of both spheres.
  settings_.isosurfaces = {{5000, {1, 1, 1}, 1}, {3000, {1, 0, 0}, 1}};
  const RegionMask opaque = visibility(1).visible;
  settings_.isosurfaces[0].opacity = 0.5f;
  const RegionMask translucent = visibility(1).visible;
  int more = 0;
  for (size_t z = 0; z < 8; ++z) {
    EXPECT_EQ(opaque.slices[z] & ~translucent.slices[z], 0u);
    for (uint64_t bits = translucent.slices[z] & ~opaque.slices[z]; bits; bits &= bits - 1) ++more;
  }
  EXPECT_GT(more, 8);
}

TEST_F(OcclusionQueryGpu, ClippedSurfacesAreNotVisibleAndOccludeNothing) {
  const RegionMask whole = visibility(1).visible;
  settings_.clip_box_low = {0, 0.5, 0};  // the half in front of the camera
  const RegionMask cut = visibility(1).visible;
  bool more = false;
  for (int bit = 0; bit < 512; ++bit) {
    const Index3 region{bit % 8, bit / 8 % 8, bit / 64};
    if (region.y < 3) {
      EXPECT_FALSE(cut.contains(region));
    } else {
      more = more || (cut.contains(region) && !whole.contains(region));
    }
  }
  EXPECT_TRUE(more);
}

TEST_F(OcclusionQueryGpu, SplatsOfThinFeaturesStayInsideTheirCoarseCells) {
  // A slope with single high voxels that are not corners of cells of level 2. The slope moves
  // samples to the faces of their cells.
  constexpr uint32_t level = 2;
  const auto stands_out = [](int32_t i) { return i % 16 == 6; };
  volume_ = sampled_volume({129, 129, 129}, {1, 1, 1}, [&](Vec3d p) {
    const bool all =
        stands_out(int32_t(p.x)) && stands_out(int32_t(p.y)) && stands_out(int32_t(p.z));
    return all ? 30000 : 10 * p.x + 5 * p.y + 2 * p.z;
  });
  settings_.isosurfaces = {{15000, {1, 1, 1}, 1}};
  renderer_->set_camera(default_camera(volume_.grid, double(kWidth) / kHeight));
  for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse}) {
    settings_.kind = kind;
    show_volume(*renderer_, volume_, 15000, 15000, level);
    renderer_->set_settings(settings_);
    ASSERT_TRUE(draw_image(*renderer_, kWidth, kHeight));
    const auto pixels = renderer_->read_surface().value();
    const CameraFrame frame = camera_frame(renderer_->camera());
    const double scale = frame.tan_half_field_of_view * 2 / kHeight;
    int hits = 0, outside = 0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      if (!pixels[size_t(i)].hit) continue;
      ++hits;
      const double x = (i % kWidth + 0.5 - 0.5 * kWidth) * scale;
      const double y = (i / kWidth + 0.5 - 0.5 * kHeight) * scale;
      const Vec3d p =
          frame.eye + (frame.forward + frame.right * x + frame.up * y) * pixels[size_t(i)].depth;
      // Voxel 6 is inside of the cell from 4 to 8.
      const auto is_inside = [](double at) {
        const double in_pattern = at - 16 * std::floor(at / 16);
        return in_pattern > 4 - 0.05 && in_pattern < 8 + 0.05;
      };
      outside += !(is_inside(p.x) && is_inside(p.y) && is_inside(p.z));
    }
    EXPECT_GT(hits, 100);
    EXPECT_EQ(outside, 0) << "of " << hits << ", kind " << int(kind);
  }
}

TEST_F(OcclusionQueryGpu, RequiresAPictureWithTheCurrentCamera) {
  const ChunkHandle handle = 0;
  EXPECT_EQ(renderer_->begin_occlusion_query({&handle, 1}, 1).error().status,
            Status::invalid_argument);
  EXPECT_FALSE(renderer_->take_occlusion_query());
  (void)visibility(1);
  Camera camera = renderer_->camera();
  camera.azimuth += 10;
  renderer_->set_camera(camera);
  EXPECT_EQ(renderer_->begin_occlusion_query({&handle, 1}, 1).error().status,
            Status::invalid_argument);
}

/// The number of GL programs. Their names are small numbers.
int count_programs() {
  int count = 0;
  for (GLuint name = 1; name < 1000; ++name) count += glIsProgram(name);
  return count;
}

TEST_F(OcclusionQueryGpu, StartsToCompileTheProgramsOfTheFastPictureThatFollows) {
  const auto extensions = reinterpret_cast<const char*>(glGetString(GL_EXTENSIONS));
  if (std::string(extensions).find("KHR_parallel_shader_compile") == std::string::npos) {
    GTEST_SKIP() << "the driver does not compile in the background";
  }
  for (const float eye_dome : {0.0f, 0.5f}) {
    settings_.eye_dome = eye_dome;
    settings_.kind = SplatKind::exact;
    (void)visibility(1);
    const int before = count_programs();
    settings_.kind = SplatKind::quad;
    renderer_->set_settings(settings_);
    const auto drawn = draw_image(*renderer_, kWidth, kHeight);
    ASSERT_TRUE(drawn);
    EXPECT_EQ(count_programs(), before) << eye_dome;
  }
}

}  // namespace
}  // namespace isosplat::render
