// Tests that gradients at lattice points are computed once, and again where chunks change. Pictures
// are compared without a threshold: all values are integers that sums represent exactly.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include "native/headless/offscreen_target.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 200;
constexpr double kIsovalue = 60.5;

/// A wavy surface through eight blocks, near the middle of each axis.
TestVolume waves() {
  return sampled_volume({129, 129, 129}, {1, 1, 1}, [](Vec3d p) {
    return 60 + 4 * (p.y - 64 + 2 * std::sin(0.4 * p.x) + 2 * std::cos(0.3 * p.z));
  });
}

class RenderLatticeGpu : public RendererTest {
 protected:
  void prepare() override {
    settings_.kind = SplatKind::exact;
    settings_.isosurfaces = {{kIsovalue, {1, 1, 1}, 1}};
    camera_.target = {64, 64, 64};
    camera_.distance = 40;
    camera_.elevation = 30;
    show(*renderer_);
  }

  void show(Renderer& renderer) const { renderer.set_volume(volume_.grid, volume_.mapping); }

  std::vector<PackedSample> samples_of(int block) const {
    return block_samples(volume_, key_of(block), kIsovalue, kIsovalue);
  }
  static BlockKey key_of(int block) { return {0, {block & 1, block >> 1 & 1, block >> 2}}; }

  FrameStatistics draw() {
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    const OffscreenTarget target(kSize, kSize);
    return renderer_->draw(kSize, kSize, target.framebuffer()).value();
  }

  static void set_visible(Renderer& renderer, const std::vector<ChunkHandle>& handles) {
    std::vector<DrawnChunk> chunks;
    for (const ChunkHandle handle : handles) chunks.push_back({handle});
    renderer.set_visible(chunks);
  }

  std::vector<uint8_t> picture(Renderer& renderer) {
    renderer.set_settings(settings_);
    renderer.set_camera(camera_);
    return draw_image(renderer, kSize, kSize).value().rgba;
  }
  /// Of a renderer that has never had other chunks. The handles are numbers of blocks.
  std::vector<uint8_t> first_picture(const std::vector<ChunkHandle>& blocks) {
    const auto renderer = std::move(*Renderer::create());
    show(*renderer);
    for (const ChunkHandle block : blocks) {
      const auto number = static_cast<int>(block);
      EXPECT_TRUE(renderer->add_chunk(block, key_of(number), samples_of(number)));
    }
    set_visible(*renderer, blocks);
    return picture(*renderer);
  }

  const TestVolume volume_ = waves();
  RenderSettings settings_;
  Camera camera_;
};

// Beside the draw calls of exact normals, a picture needs two.
TEST_F(RenderLatticeGpu, GradientsAreComputedOnce) {
  for (int block = 0; block < 8; ++block) {
    ASSERT_TRUE(renderer_->add_chunk(ChunkHandle(block), key_of(block), samples_of(block)));
  }
  set_visible(*renderer_, {0, 1, 2, 3, 4, 5, 6, 7});
  settings_.shading = Shading::exact;
  const uint32_t exact = draw().draw_calls;
  settings_.shading = Shading::smooth;
  EXPECT_GT(draw().draw_calls, exact + 2);
  EXPECT_EQ(draw().draw_calls, exact + 2);
  camera_.azimuth += 0.1;
  const uint32_t smooth = draw().draw_calls;
  settings_.shading = Shading::exact;
  EXPECT_EQ(smooth, draw().draw_calls + 2);
}

// In close-ups, quads are triangles whose normals are interpolated between vertices. Their angles
// to those of exact splats are below 1° in the median and 4° at the 95th percentile. With exact
// shading, they are larger than that.
TEST_F(RenderLatticeGpu, TrianglesAreSmooth) {
  for (int block = 0; block < 8; ++block) {
    ASSERT_TRUE(renderer_->add_chunk(ChunkHandle(block), key_of(block), samples_of(block)));
  }
  set_visible(*renderer_, {0, 1, 2, 3, 4, 5, 6, 7});
  camera_.distance = 30;
  (void)draw();
  const auto truth = renderer_->read_surface().value();
  settings_.kind = SplatKind::quad;
  const auto angles = [&] {
    (void)draw();
    const auto found = renderer_->read_surface().value();
    std::vector<double> result;
    for (size_t i = 0; i < found.size(); ++i) {
      if (!found[i].hit || !truth[i].hit || std::abs(found[i].depth - truth[i].depth) > 0.2) {
        continue;
      }
      const double cosine = double(dot(found[i].normal, truth[i].normal));
      result.push_back(std::acos(std::min(cosine, 1.0)) * 180 / std::acos(-1.0));
    }
    std::sort(result.begin(), result.end());
    return result;
  };
  const auto smooth = angles();
  ASSERT_GT(smooth.size(), size_t{10000});
  EXPECT_LT(smooth[smooth.size() / 2], 1);
  EXPECT_LT(smooth[smooth.size() * 95 / 100], 4);
  settings_.shading = Shading::exact;
  const auto exact = angles();
  EXPECT_GT(exact[exact.size() / 2], 1);
  EXPECT_GT(exact[exact.size() * 95 / 100], 4);
}

// A chunk of a coarser level, too far away for smooth normals, changes neither their cost nor the
// normals before it.
TEST_F(RenderLatticeGpu, FarCoarseChunksDoNotMatter) {
  const TestVolume volume = sampled_volume({65, 129, 65}, {1, 1, 1}, [](Vec3d p) {
    return 60 + 4 * (p.x - 32 + 2 * std::sin(0.4 * p.y) + std::cos(0.5 * p.z));
  });
  renderer_->set_volume(volume.grid, volume.mapping);
  const BlockKey fine{0, {0, 0, 0}}, coarse{1, {0, 0, 0}};
  ASSERT_TRUE(renderer_->add_chunk(0, fine, block_samples(volume, fine, kIsovalue, kIsovalue)));
  ASSERT_TRUE(renderer_->add_chunk(1, coarse, block_samples(volume, coarse, kIsovalue, kIsovalue)));
  RegionMask behind;
  for (int i = 0; i < 8 * 4 * 8; ++i) behind.insert({i & 7, 4 + (i >> 3 & 3), i >> 5});
  camera_.target = {44, 40, 32};
  camera_.distance = 85;
  camera_.field_of_view = 45;
  camera_.azimuth = camera_.elevation = 0;
  const DrawnChunk front[] = {{0}}, both[] = {{0}, {1, behind}};
  renderer_->set_visible(front);
  (void)picture(*renderer_);
  const auto alone = renderer_->read_surface().value();
  renderer_->set_visible(both);
  settings_.shading = Shading::exact;
  const uint32_t exact = draw().draw_calls;
  settings_.shading = Shading::smooth;
  (void)draw();
  EXPECT_EQ(draw().draw_calls, exact + 2);
  const auto found = renderer_->read_surface().value();
  int same = 0, more = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    more += found[i].hit && !alone[i].hit;
    if (!alone[i].hit || found[i].depth != alone[i].depth) continue;
    ++same;
    ASSERT_EQ(found[i].normal.x, alone[i].normal.x);
    ASSERT_EQ(found[i].normal.y, alone[i].normal.y);
  }
  EXPECT_GT(same, 1000);
  EXPECT_GT(more, 100);
}

TEST_F(RenderLatticeGpu, GradientsFollowTheChunks) {
  std::vector<ChunkHandle> blocks;
  for (const ChunkHandle block : {2u, 0u, 7u, 3u, 5u, 1u, 4u, 6u}) {
    blocks.push_back(block);
    const auto number = static_cast<int>(block);
    ASSERT_TRUE(renderer_->add_chunk(block, key_of(number), samples_of(number)));
    set_visible(*renderer_, blocks);
    ASSERT_EQ(picture(*renderer_), first_picture(blocks)) << block;
  }
  while (blocks.size() > 1) {
    renderer_->remove_chunk(blocks.front());
    blocks.erase(blocks.begin());
    set_visible(*renderer_, blocks);
    ASSERT_EQ(picture(*renderer_), first_picture(blocks)) << blocks.front();
  }
}

// Another volume in the place of the first one, with chunks of the same blocks and handles.
TEST_F(RenderLatticeGpu, GradientsAreThoseOfTheVolume) {
  const auto show_all = [&](Renderer& renderer) {
    show(renderer);
    for (int block = 0; block < 8; ++block) {
      ASSERT_TRUE(renderer.add_chunk(ChunkHandle(block), key_of(block), samples_of(block)));
    }
    set_visible(renderer, {0, 1, 2, 3, 4, 5, 6, 7});
  };
  show_all(*renderer_);
  const auto before = picture(*renderer_);
  camera_.target.y = 66;
  const auto moved = picture(*renderer_);
  EXPECT_NE(moved, before);
  renderer_->set_volume(volume_.grid, volume_.mapping);
  EXPECT_NE(picture(*renderer_), moved);
  show_all(*renderer_);
  EXPECT_EQ(picture(*renderer_), moved);
}

// An isosurface that no chunk in view crosses changes nothing.
TEST_F(RenderLatticeGpu, IsosurfacesMayBeOutOfView) {
  ASSERT_TRUE(renderer_->add_chunk(0, key_of(0), samples_of(0)));
  set_visible(*renderer_, {0});
  const auto alone = picture(*renderer_);
  settings_.isosurfaces.push_back({5000, {1, 0, 0}, 1});
  EXPECT_EQ(picture(*renderer_), alone);
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
}

// Each isosurface has the gradients of the chunks in which it lies, here two of each block.
TEST_F(RenderLatticeGpu, IsosurfacesHaveTheirOwnGradients) {
  constexpr double kOther = 90.5;
  const auto show_both = [&](Renderer& renderer, bool has_other) {
    show(renderer);
    std::vector<ChunkHandle> handles;
    for (int block = 0; block < 8; ++block) {
      handles.push_back(ChunkHandle(block));
      ASSERT_TRUE(renderer.add_chunk(handles.back(), key_of(block), samples_of(block)));
      if (!has_other) continue;
      handles.push_back(ChunkHandle(block + 8));
      ASSERT_TRUE(renderer.add_chunk(handles.back(), key_of(block),
                                     block_samples(volume_, key_of(block), kOther, kOther)));
    }
    set_visible(renderer, handles);
  };
  const auto normals = [&](Renderer& renderer) {
    (void)picture(renderer);
    return renderer.read_surface().value();
  };
  show_both(*renderer_, false);
  const auto alone = normals(*renderer_);
  show_both(*renderer_, true);
  settings_.isosurfaces.push_back({kOther, {1, 0, 0}, 1});
  for (int repeat = 0; repeat < 2; ++repeat) {
    const auto both = normals(*renderer_);
    int same = 0;
    for (size_t i = 0; i < both.size(); ++i) {
      if (!both[i].hit || both[i].isosurface != 0) continue;
      ASSERT_NEAR(both[i].normal.x, alone[i].normal.x, 1e-3);
      ASSERT_NEAR(both[i].normal.y, alone[i].normal.y, 1e-3);
      ++same;
    }
    EXPECT_GT(same, 1000);
  }
}

}  // namespace
}  // namespace isosplat::render
