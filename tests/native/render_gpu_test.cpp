// Pictures of analytic fields, drawn by any GPU that EGL offers (llvmpipe if there is none). Each
// comparison states its thresholds.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numeric>
#include <thread>

#include "native/headless/draw_image.h"
#include "native/headless/offscreen_target.h"
#include "native/headless/ray_caster.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

class RenderGpu : public RendererTest {
 protected:
  struct Difference {
    double holes = 0;       // pixels that the reference and its neighbours cover, but ours does not
    double silhouette = 0;  // differing pixels / the reference's
    double depth = 0;       // mean, in cells (smallest spacing)
    double normal = 0;      // mean, degrees
    int reference = 0;
  };

  Difference compare(const TestVolume& volume, double isovalue, int width, int height) {
    const auto pixels = renderer_->read_surface();
    EXPECT_TRUE(pixels);
    const RayCaster caster(volume.grid, volume.quantized_values, volume.mapping.has_missing);
    const CameraFrame frame = camera_frame(renderer_->camera());
    const double cell =
        std::min({volume.grid.spacing.x, volume.grid.spacing.y, volume.grid.spacing.z});
    Difference d;
    int both = 0, differing = 0;
    std::vector<char> hit(size_t(width) * size_t(height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const size_t i = size_t(y) * size_t(width) + size_t(x);
        const auto truth = caster.cast(renderer_->camera(), width, height, x, y,
                                       volume.mapping.quantized_isovalue(isovalue));
        hit[i] = truth.has_value();
        const auto& ours = (*pixels)[i];
        d.reference += truth.has_value();
        const bool covered = ours.hit;
        differing += truth.has_value() != covered;
        if (!truth || !covered) continue;
        ++both;
        d.depth += std::abs(truth->depth - double(ours.depth)) / cell;
        const Vec3d n = frame.right * double(ours.normal.x) + frame.up * double(ours.normal.y) -
                        frame.forward * double(ours.normal.z);
        d.normal += std::acos(std::min(1.0, std::abs(dot(n, truth->normal)))) * 180 / 3.14159265;
      }
    }
    for (int y = 2; y < height - 2; ++y) {
      for (int x = 2; x < width - 2; ++x) {
        bool deep = true;
        for (int j = -2; j <= 2; ++j) {
          for (int i = -2; i <= 2; ++i) {
            deep = deep && hit[size_t(y + j) * size_t(width) + size_t(x + i)];
          }
        }
        d.holes += deep && !(*pixels)[size_t(y) * size_t(width) + size_t(x)].hit;
      }
    }
    d.silhouette = double(differing) / std::max(1, d.reference);
    d.depth /= std::max(1, both);
    d.normal /= std::max(1, both);
    return d;
  }
};

constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::exact};
constexpr const char* kKindNames[] = {"quad", "ellipse", "exact"};

TEST_F(RenderGpu, EveryKindDrawsASphere) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  Camera camera = default_camera(volume.grid);
  camera.distance *= 1.2;  // so that cells are small enough to be squares and ellipses
  renderer_->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  settings.shading = Shading::exact;  // as the reference
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    renderer_->set_settings(settings);
    const auto image = draw_image(*renderer_, 512, 512);
    ASSERT_TRUE(image) << image.error().message;
    const char* name = kKindNames[static_cast<int>(kind)];
    keep(*image, std::string("sphere-") + name);
    const Difference d = compare(volume, 2500, 512, 512);
    EXPECT_GT(d.reference, 10000) << name;
    EXPECT_EQ(d.holes, 0) << name;
    // Largest share of differing pixels, mean depth error in cells, mean normal error in degrees.
    struct Limits {
      double silhouette, depth, normal;
    };
    constexpr Limits kLimits[] = {{0.02, 0.3, 2}, {0.003, 0.01, 0.4}, {0.0005, 0.001, 0.05}};
    const Limits& limits = kLimits[static_cast<int>(kind)];
    EXPECT_LT(d.silhouette, limits.silhouette) << name;
    EXPECT_LT(d.depth, limits.depth) << name;
    EXPECT_LT(d.normal, limits.normal) << name;
  }
}

TEST_F(RenderGpu, AnisotropicSpacingIsNotSquashed) {
  const TestVolume volume = sphere_volume({60, 50, 24}, {1, 1.25, 2.5});
  show_volume(*renderer_, volume, 2000, 2000);
  Camera camera = default_camera(volume.grid);
  camera.distance *= 1.4;
  renderer_->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{2000, {0.85f, 0.8f, 0.7f}, 1}};
  constexpr double kSilhouette[] = {0.04, 0.005, 0.001};
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    renderer_->set_settings(settings);
    ASSERT_TRUE(draw_image(*renderer_, 300, 300));
    const Difference d = compare(volume, 2000, 300, 300);
    const char* name = kKindNames[static_cast<int>(kind)];
    EXPECT_EQ(d.holes, 0) << name;
    EXPECT_LT(d.silhouette, kSilhouette[static_cast<int>(kind)]) << name;
  }
}

// With many samples per pixel, the renderer drops samples that are behind what is already drawn. It
// must not drop any visible sample.
TEST_F(RenderGpu, DropsHiddenSamplesOnly) {
  const TestVolume volume = sphere_volume({130, 130, 130});
  const uint64_t samples = show_volume(*renderer_, volume, 5500, 5500);
  constexpr int kSize = 200;
  EXPECT_GT(samples, uint64_t{4} * kSize * kSize / 10);
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.8;
  renderer_->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{5500, {0.85f, 0.8f, 0.7f}, 1}};
  settings.clip_box_high.x = 0.7;  // the far wall is seen from inside
  constexpr size_t kChunks = 27;
  std::vector<ChunkHandle> all(kChunks);
  std::iota(all.begin(), all.end(), ChunkHandle{0});
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    renderer_->set_settings(settings);
    const auto depths = [&](std::span<const ChunkHandle> chunks) {
      renderer_->set_visible(chunks);
      EXPECT_TRUE(draw_image(*renderer_, kSize, kSize));
      const auto pixels = renderer_->read_surface();
      EXPECT_TRUE(pixels);
      std::vector<float> result;
      for (const auto& pixel : *pixels) result.push_back(pixel.hit ? pixel.depth : 1e9f);
      return result;
    };
    const std::vector<float> together = depths(all);
    std::vector<float> nearest(together.size(), 1e9f);
    for (const ChunkHandle& chunk : all) {
      const std::vector<float> alone = depths({&chunk, 1});
      for (size_t i = 0; i < alone.size(); ++i) nearest[i] = std::min(nearest[i], alone[i]);
    }
    EXPECT_EQ(together, nearest) << kKindNames[static_cast<int>(kind)];
  }
}

// Opaque quads are lit when they are drawn, others in a later pass. The colours differ by a few
// steps only, because the viewing direction is taken at the centre of a quad.
TEST_F(RenderGpu, SquaresAreLitAlikeInBothWays) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 2000, 2000);
  RenderSettings settings;
  settings.kind = SplatKind::quad;
  settings.background = {0.2f, 0.4f, 0.6f, 0.5f};
  settings.colour_low = 0;
  settings.colour_high = 600;
  Camera camera = default_camera(volume.grid);
  for (const double distance : {1.0, 0.15}) {  // squares, and ray-cast ones for those too large
    camera.distance = default_camera(volume.grid).distance * distance;
    renderer_->set_camera(camera);
    for (const ColourBy colour_by : {ColourBy::isosurface, ColourBy::gradient, ColourBy::depth}) {
      for (const float eye_dome : {0.0f, 0.5f}) {
        settings.colour_by = colour_by;
        settings.eye_dome = eye_dome;
        settings.isosurfaces = {{2000, {0.85f, 0.5f, 0.3f}, 1}};
        renderer_->set_settings(settings);
        const auto at_once = draw_image(*renderer_, 200, 200);
        // A translucent isosurface requires layers, even if no sample belongs to it.
        settings.isosurfaces.push_back({-1e6, {1, 1, 1}, 0.5f});
        renderer_->set_settings(settings);
        const auto from_layers = draw_image(*renderer_, 200, 200);
        ASSERT_TRUE(at_once && from_layers);
        EXPECT_NE(at_once->rgba, from_layers->rgba);  // they are drawn in different ways
        int most = 0;
        for (size_t i = 0; i < at_once->rgba.size(); ++i) {
          most = std::max(most, std::abs(int{at_once->rgba[i]} - int{from_layers->rgba[i]}));
        }
        EXPECT_LE(most, 6) << static_cast<int>(colour_by) << " at " << distance << ", eye-dome "
                           << eye_dome;
      }
    }
  }
}

// An isosurface that occludes itself must not hide another isosurface.
TEST_F(RenderGpu, TranslucentSurfacesHideNothing) {
  const TestVolume volume = sphere_volume({130, 130, 130});
  show_volume(*renderer_, volume, 4000, 5500);
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.8;
  renderer_->set_camera(camera);
  constexpr int kSize = 200;
  RenderSettings settings;
  const auto opaque_depths = [&](std::vector<Isosurface> isosurfaces) {
    settings.isosurfaces = std::move(isosurfaces);
    renderer_->set_settings(settings);
    EXPECT_TRUE(draw_image(*renderer_, kSize, kSize));
    const auto pixels = renderer_->read_surface();
    EXPECT_TRUE(pixels);
    std::vector<float> depths;
    for (const auto& pixel : *pixels) depths.push_back(pixel.hit ? pixel.depth : 0);
    return depths;
  };
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    for (const auto& [translucent, opaque] : {std::pair{4000, 5500}, std::pair{5500, 4000}}) {
      const Isosurface shell{double(translucent), {1, 1, 1}, 0.4f},
          inside{double(opaque), {1, 1, 1}, 1};
      EXPECT_EQ(opaque_depths({shell, inside}), opaque_depths({inside}))
          << kKindNames[static_cast<int>(kind)] << ", " << opaque << " behind " << translucent;
    }
  }
}

// A fade shows the first picture at its start, the second one at its end, and a mixture in between.
// A third picture fades in from the current mixture.
TEST_F(RenderGpu, PicturesFadeIntoEachOther) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 800, 1700);
  renderer_->set_camera(default_camera(volume.grid));
  constexpr int kSize = 64;
  GLuint texture = 0, framebuffer = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, kSize, kSize);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  const auto shown = [&] {
    std::vector<uint8_t> pixels(4 * kSize * kSize);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glReadPixels(0, 0, kSize, kSize, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  };
  const auto drawn = [&](double isovalue) {
    RenderSettings settings;
    settings.isosurfaces = {{isovalue, {0.85f, 0.8f, 0.7f}, 1}};
    renderer_->set_settings(settings);
    EXPECT_TRUE(renderer_->draw(kSize, kSize, framebuffer));
    return shown();
  };

  EXPECT_FALSE(renderer_->hold_picture(framebuffer));  // nothing has been drawn
  const auto first = drawn(800);
  EXPECT_EQ(renderer_->begin_fade(framebuffer), false);
  EXPECT_EQ(shown(), first);
  ASSERT_TRUE(renderer_->hold_picture(framebuffer));
  const auto second = drawn(1700);
  ASSERT_NE(first, second);
  EXPECT_EQ(renderer_->begin_fade(framebuffer), true);
  EXPECT_EQ(shown(), first);
  ASSERT_TRUE(renderer_->fade(0.25f, framebuffer));
  const auto between = shown();
  for (size_t i = 0; i < first.size(); ++i) {
    ASSERT_NEAR(between[i], 0.75 * first[i] + 0.25 * second[i], 1) << i;
  }
  ASSERT_TRUE(renderer_->hold_picture(framebuffer));
  const auto third = drawn(1200);
  EXPECT_EQ(renderer_->begin_fade(framebuffer), true);
  EXPECT_EQ(shown(), between);
  ASSERT_TRUE(renderer_->fade(1, framebuffer));
  EXPECT_EQ(shown(), third);
  // The next fade begins with this picture. A picture of another size is replaced without a fade.
  drawn(800);
  EXPECT_EQ(renderer_->begin_fade(framebuffer), true);
  EXPECT_EQ(shown(), third);
  EXPECT_TRUE(renderer_->draw(kSize / 2, kSize, framebuffer));
  EXPECT_EQ(renderer_->begin_fade(framebuffer), false);
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteTextures(1, &texture);
}

/// The number of connected components of the set pixels, with 8 neighbours.
int pieces(std::vector<char> set, int width, int height) {
  int count = 0;
  std::vector<int> open;
  for (int start = 0; start < width * height; ++start) {
    if (!set[size_t(start)]) continue;
    ++count;
    set[size_t(start)] = 0;
    for (open = {start}; !open.empty();) {
      const int x = open.back() % width, y = open.back() / width;
      open.pop_back();
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j) {
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) {
          char& there = set[size_t(j * width + i)];
          if (there) open.push_back(j * width + i);
          there = 0;
        }
      }
    }
  }
  return count;
}

// A vessel about as wide as a cell. It winds, so that its cells contain two walls at all angles.
// All splat kinds draw it as one connected component, from near and far.
TEST_F(RenderGpu, ThinVesselsStayConnected) {
  const TestVolume volume = sampled_volume({40, 40, 40}, {1, 1, 1}, [](Vec3d p) {
    double nearest = 1e9;
    for (int i = 0; i <= 400; ++i) {
      const double angle = i * 0.04;
      const Vec3d on{19.5 + 14 * std::cos(angle), 19.5 + 14 * std::sin(angle), 4 + 0.075 * i};
      nearest = std::min(nearest, length(p - on));
    }
    return 200 * std::exp(-nearest * nearest);
  });
  show_volume(*renderer_, volume, 80.5, 80.5);
  RenderSettings settings;
  settings.isosurfaces = {{80.5, {0.85f, 0.8f, 0.7f}, 1}};
  Camera camera = default_camera(volume.grid);
  for (const double distance : {0.6, 1.8}) {
    camera = default_camera(volume.grid);
    camera.distance *= distance;
    renderer_->set_camera(camera);
    for (const SplatKind kind : kKinds) {
      settings.kind = kind;
      renderer_->set_settings(settings);
      const auto image = draw_image(*renderer_, 400, 400);
      ASSERT_TRUE(image);
      keep(*image, std::string("vessel-") + kKindNames[static_cast<int>(kind)]);
      const auto pixels = renderer_->read_surface();
      ASSERT_TRUE(pixels);
      std::vector<char> covered;
      for (const auto& pixel : *pixels) covered.push_back(pixel.hit);
      EXPECT_EQ(pieces(covered, 400, 400), 1) << kKindNames[static_cast<int>(kind)] << distance;
    }
  }
}

// One layer of cells with random corners. Most contain several sheets, or one that a plane cannot
// approximate, and nothing behind them hides holes. Pixels within 2 px of the reference's outline
// are not counted. At most 0.06 % may be holes: triangles are the chords of curved outlines (0.3 %
// of quads are holes if each is as large as the part of the tangent plane in the cell).
TEST_F(RenderGpu, SquaresCoverCellsWithSeveralSheets) {
  uint32_t state = 1;
  const TestVolume volume = sampled_volume({64, 64, 2}, {1, 1, 1}, [&](Vec3d) {
    state = state * 1664525 + 1013904223;
    return double(state >> 24);
  });
  show_volume(*renderer_, volume, 90.5, 90.5);
  Camera camera = default_camera(volume.grid);
  camera.elevation = 70;
  camera.distance *= 0.8;
  renderer_->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{90.5, {0.85f, 0.8f, 0.7f}, 1}};
  settings.kind = SplatKind::quad;
  renderer_->set_settings(settings);
  const auto image = draw_image(*renderer_, 600, 600);
  ASSERT_TRUE(image);
  keep(*image, "sheets-quad");
  const Difference d = compare(volume, 90.5, 600, 600);
  EXPECT_GT(d.reference, 20000);
  EXPECT_LT(d.holes, 0.0006 * d.reference);
}

// If points cannot be as large as the splats, triangles draw the same picture: at most 0.2 % of
// pixels differ in coverage, and depths differ by rounding only.
TEST_F(RenderGpu, TrianglesStandInForPointsThatAreTooLarge) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.4;
  auto small_points = Renderer::create(4);
  ASSERT_TRUE(small_points);
  RenderSettings settings;
  settings.isosurfaces = {{1500, {0.85f, 0.8f, 0.7f}, 1}};
  for (Renderer* renderer : {renderer_.get(), small_points->get()}) {
    show_volume(*renderer, volume, 1500, 1500);
    renderer->set_camera(camera);
  }
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    std::vector<SurfacePixel> pixels[2];
    int i = 0;
    for (Renderer* renderer : {renderer_.get(), small_points->get()}) {
      renderer->set_settings(settings);
      ASSERT_TRUE(draw_image(*renderer, 256, 256));
      pixels[i++] = renderer->read_surface().value();
    }
    int differing = 0, hits = 0;
    for (size_t p = 0; p < pixels[0].size(); ++p) {
      hits += pixels[0][p].hit;
      differing += pixels[0][p].hit != pixels[1][p].hit ||
                   std::abs(pixels[0][p].depth - pixels[1][p].depth) > 0.01f;
    }
    EXPECT_GT(hits, 20000);
    EXPECT_LT(differing, 66) << kKindNames[static_cast<int>(kind)];
  }
}

TEST_F(RenderGpu, ClipBoxAndPlanesCutAndOpenTheView) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 1500, 1500);
  Camera camera = default_camera(volume.grid);
  camera.azimuth = camera.elevation = 0;  // looks along +y
  renderer_->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{1500, {0.85f, 0.8f, 0.7f}, 1}};
  const size_t middle = 128 * 256 + 128;
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    settings.clip_box_low = {0, 0, 0};
    settings.clip_planes.clear();
    renderer_->set_settings(settings);
    ASSERT_TRUE(draw_image(*renderer_, 256, 256));
    const float front = renderer_->read_surface().value()[middle].depth;
    EXPECT_NEAR(double(front), camera.distance - 15, 0.8);

    settings.clip_box_low = {0, 0.5, 0};  // clips the near half: the far wall is visible
    renderer_->set_settings(settings);
    ASSERT_TRUE(draw_image(*renderer_, 256, 256));
    const float back = renderer_->read_surface().value()[middle].depth;
    EXPECT_NEAR(double(back), camera.distance + 15, 0.8) << kKindNames[static_cast<int>(kind)];

    settings.clip_planes = {{{0, -1, 0}, -19.5}};  // clips the far half as well: nothing is left
    renderer_->set_settings(settings);
    ASSERT_TRUE(draw_image(*renderer_, 256, 256));
    EXPECT_FALSE(renderer_->read_surface().value()[middle].hit);
  }
}

TEST_F(RenderGpu, CutsFollowTheClipPlaneExactly) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 1500, 1500);
  renderer_->set_camera(default_camera(volume.grid));
  RenderSettings settings;
  settings.isosurfaces = {{1500, {0.85f, 0.8f, 0.7f}, 1}};
  settings.clip_planes = {{{0.8, 0.36, 0.48}, 30}};  // oblique to the cells
  std::vector<SurfacePixel> exact;
  for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse}) {
    settings.kind = kind;
    renderer_->set_settings(settings);
    ASSERT_TRUE(draw_image(*renderer_, 256, 256));
    const std::vector<SurfacePixel> pixels = renderer_->read_surface().value();
    if (kind == SplatKind::exact) exact = pixels;
    int hits = 0, differing = 0;
    for (size_t p = 0; p < pixels.size(); ++p) {
      hits += exact[p].hit;
      differing += pixels[p].hit != exact[p].hit || std::abs(pixels[p].depth - exact[p].depth) > 1;
    }
    EXPECT_GT(hits, 5000);
    EXPECT_LE(differing, hits / 150) << kKindNames[static_cast<int>(kind)];
  }
}

TEST_F(RenderGpu, TranslucentSurfacesDoNotDependOnTheirOrder) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 800, 1700);
  Camera camera = default_camera(volume.grid);
  renderer_->set_camera(camera);
  const Isosurface bone{800, {0.9f, 0.2f, 0.1f}, 1}, skin{1700, {0.2f, 0.4f, 0.9f}, 0.4f},
      between{1200, {0.1f, 0.8f, 0.2f}, 0.3f};
  RenderSettings settings;
  settings.kind = SplatKind::exact;
  settings.isosurfaces = {bone, skin, between};
  renderer_->set_settings(settings);
  const auto one = draw_image(*renderer_, 256, 256);
  settings.isosurfaces = {between, bone, skin};
  renderer_->set_settings(settings);
  const auto other = draw_image(*renderer_, 256, 256);
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->rgba, other->rgba);
  const uint8_t* middle = one->at(128, 128);
  EXPECT_GT(middle[0], 60);  // red is visible through blue
  EXPECT_GT(middle[2], 60);  // blue is in front
  keep(*one, "translucent");
}

TEST_F(RenderGpu, StillViewsNeedNoRedrawAndChangesDo) {
  const TestVolume volume = sphere_volume({20, 20, 20});
  show_volume(*renderer_, volume, 500, 500);
  RenderSettings settings;
  settings.isosurfaces = {{500, {1, 1, 1}, 1}};
  renderer_->set_settings(settings);
  renderer_->set_camera(default_camera(volume.grid));
  EXPECT_TRUE(renderer_->needs_redraw(64, 64));
  ASSERT_TRUE(draw_image(*renderer_, 64, 64));
  EXPECT_FALSE(renderer_->needs_redraw(64, 64));
  EXPECT_TRUE(renderer_->needs_redraw(65, 64));
  renderer_->set_settings(settings);
  EXPECT_FALSE(renderer_->needs_redraw(64, 64));
  settings.isosurfaces[0].isovalue = 600;
  renderer_->set_settings(settings);
  EXPECT_TRUE(renderer_->needs_redraw(64, 64));
  ASSERT_TRUE(draw_image(*renderer_, 64, 64));
  renderer_->remove_chunk(0);
  EXPECT_TRUE(renderer_->needs_redraw(64, 64));
}

TEST_F(RenderGpu, WarmingUpChangesNoPicture) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  auto warmed = std::move(*Renderer::create());
  while (!warmed->is_compiled()) std::this_thread::yield();
  ASSERT_TRUE(warmed->warm_up(OffscreenTarget(1, 1).framebuffer()));
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  std::vector<uint8_t> pictures[2];
  int i = 0;
  for (Renderer* renderer : {renderer_.get(), warmed.get()}) {
    show_volume(*renderer, volume, 1500, 1500);
    const auto image = draw_image(*renderer, 128, 128);
    ASSERT_TRUE(image);
    pictures[i++] = image->rgba;
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

// The mean of pictures that are shifted by fractions of a pixel equals a much larger picture,
// reduced.
TEST_F(RenderGpu, RefiningSmoothsEdges) {
  const TestVolume volume = sphere_volume({20, 20, 20});
  show_volume(*renderer_, volume, 500, 500);
  RenderSettings settings;
  settings.isosurfaces = {{500, {1, 1, 1}, 1}};
  settings.background = {0, 0, 0, 1};
  settings.eye_dome = 0;  // its radius is in pixels
  settings.kind = SplatKind::exact;
  renderer_->set_settings(settings);
  renderer_->set_camera(default_camera(volume.grid));

  constexpr int kSize = 96, kTimes = 8;
  const auto large = draw_image(*renderer_, kSize * kTimes, kSize * kTimes);
  const auto jagged = draw_image(*renderer_, kSize, kSize);
  EXPECT_TRUE(renderer_->can_refine(kSize, kSize));
  EXPECT_FALSE(renderer_->can_refine(kSize + 1, kSize));
  const auto smooth = draw_image(*renderer_, kSize, kSize, nullptr, true);
  ASSERT_TRUE(large && jagged && smooth);
  EXPECT_FALSE(renderer_->can_refine(kSize, kSize)) << "the picture is fully refined";
  EXPECT_FALSE(renderer_->needs_redraw(kSize, kSize));
  EXPECT_EQ(renderer_->refine(kSize, kSize).error().status, Status::invalid_argument);
  keep(*smooth, "smooth");

  const auto light = [](const Image& image, int x, int y) {
    const double value = image.at(x, y)[1] / 255.0;
    return value * value;
  };
  const auto error_of = [&](const Image& image) {
    double sum = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        double mean = 0;
        for (int i = 0; i < kTimes * kTimes; ++i) {
          mean += light(*large, x * kTimes + i % kTimes, y * kTimes + i / kTimes);
        }
        const double difference = light(image, x, y) - mean / (kTimes * kTimes);
        sum += difference * difference;
      }
    }
    return std::sqrt(sum);
  };
  EXPECT_LT(error_of(*smooth), 0.45 * error_of(*jagged));

  settings.isosurfaces[0].isovalue = 600;
  renderer_->set_settings(settings);
  EXPECT_FALSE(renderer_->can_refine(kSize, kSize)) << "a change must be drawn first";
}

TEST_F(RenderGpu, RefiningWaitsForNoShaderThatWasPrepared) {
  const TestVolume volume = sphere_volume({20, 20, 20});
  show_volume(*renderer_, volume, 500, 500);
  RenderSettings settings;
  settings.isosurfaces = {{500, {1, 1, 1}, 1}};
  for (const SplatKind kind : {SplatKind::exact, SplatKind::quad}) {
    for (const bool clipped : {false, true}) {
      for (const bool prepared : {true, false}) {
        settings.kind = kind;
        settings.clip_box_low = {clipped ? 0.3 : 0, 0, 0};
        auto renderer = Renderer::create();
        ASSERT_TRUE(renderer);
        show_volume(**renderer, volume, 500, 500);
        (*renderer)->set_settings(settings);
        (*renderer)->set_camera(default_camera(volume.grid));
        constexpr int kSize = 96;
        ASSERT_TRUE(draw_image(**renderer, kSize, kSize));
        for (int tries = 0; prepared && !(*renderer)->prepare_refine(); ++tries) {
          ASSERT_LT(tries, 3000) << "the driver does not finish compiling";
          std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        ASSERT_TRUE((*renderer)->can_refine(kSize, kSize)) << "nothing was drawn";
        const OffscreenTarget target(kSize, kSize);
        const auto refined = (*renderer)->refine(kSize, kSize, target.framebuffer());
        ASSERT_TRUE(refined);
        EXPECT_EQ(refined->programs_linked == 0, prepared) << int(kind) << clipped;
      }
    }
  }
}

TEST_F(RenderGpu, AStillPictureIsDrawnOnceAndShownAgain) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 1000, 1000);
  renderer_->set_camera(default_camera(volume.grid));
  RenderSettings settings;
  settings.isosurfaces = {{1000, {1, 0.8f, 0.6f}, 1}};
  settings.kind = SplatKind::exact;
  renderer_->set_settings(settings);
  constexpr int kSize = 96;
  ASSERT_TRUE(draw_image(*renderer_, kSize, kSize));  // links the programs
  FrameStatistics first, again, other;
  const auto picture = draw_image(*renderer_, kSize, kSize, &first, true);
  EXPECT_GT(first.samples_drawn, 0u);
  // Draw into another framebuffer, so that the result cannot be a remnant in the first one.
  const auto shown = draw_image(*renderer_, kSize, kSize, &again, true);
  ASSERT_TRUE(picture && shown);
  EXPECT_TRUE(shown->rgba == picture->rgba);
  EXPECT_EQ(again.samples_drawn, 0u);
  EXPECT_EQ(again.draw_calls, 1u);
  EXPECT_EQ(again.samples_resident, first.samples_resident);
  // After a change, a new picture is drawn.
  settings.isosurfaces[0].isovalue = 900;
  renderer_->set_settings(settings);
  const auto changed = draw_image(*renderer_, kSize, kSize, &other, true);
  ASSERT_TRUE(changed);
  EXPECT_GT(other.samples_drawn, 0u);
  EXPECT_FALSE(changed->rgba == picture->rgba);
}

// The mean of each channel changes by at most 1 of 255 (edges fall on other pixels).
TEST_F(RenderGpu, RefiningKeepsTheLightOfEveryKind) {
  const TestVolume volume = sphere_volume({40, 40, 40});
  show_volume(*renderer_, volume, 1000, 1500);
  renderer_->set_camera(default_camera(volume.grid));
  RenderSettings settings;
  settings.isosurfaces = {{1500, {0.2f, 0.5f, 1}, 0.4f}, {1000, {1, 0.8f, 0.6f}, 1}};
  settings.background = {0, 0, 0, 0};
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    renderer_->set_settings(settings);
    const auto plain = draw_image(*renderer_, 160, 160);
    const auto refined = draw_image(*renderer_, 160, 160, nullptr, true);
    ASSERT_TRUE(plain && refined);
    for (size_t channel = 0; channel < 4; ++channel) {
      double difference = 0;
      for (size_t i = channel; i < plain->rgba.size(); i += 4) {
        difference += double(plain->rgba[i]) - double(refined->rgba[i]);
      }
      EXPECT_NEAR(difference / (160 * 160), 0, 1) << kKindNames[static_cast<int>(kind)] << channel;
    }
  }
}

TEST_F(RenderGpu, RefusesInvalidInput) {
  EXPECT_EQ(renderer_->draw(0, 10).error().status, Status::invalid_argument);
  EXPECT_EQ(renderer_->draw(10, 100000).error().status, Status::invalid_argument);
  EXPECT_EQ(renderer_->read_surface().error().status, Status::invalid_argument);
  EXPECT_EQ(renderer_->add_chunk(1, {}, {}).error().status, Status::invalid_argument);
  renderer_->set_volume(sphere_volume({20, 20, 20}).grid, {});
  EXPECT_EQ(renderer_->add_chunk(1, {0, {1, 0, 0}}, {}).error().status, Status::invalid_argument);
  EXPECT_EQ(renderer_->add_chunk(1, {9, {0, 0, 0}}, {}).error().status, Status::invalid_argument);
  renderer_->context_lost();
  EXPECT_EQ(renderer_->draw(10, 10).error().status, Status::gl_error);
  EXPECT_FALSE(renderer_->needs_redraw(10, 10));
  ASSERT_TRUE(renderer_->context_restored());
  EXPECT_TRUE(renderer_->draw(10, 10));
}

}  // namespace
}  // namespace isosplat::render
