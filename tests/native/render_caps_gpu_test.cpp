// Caps of the clipping, compared with closed forms and, pixel by pixel, with the values of the
// volume on the cut faces. Each comparison states its thresholds.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "native/headless/draw_image.h"
#include "shared/core/sampling/trilinear.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 320;
constexpr double kPi = 3.14159265358979;
constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::exact};
constexpr const char* kKindNames[] = {"quad", "ellipse", "exact"};

/// A solid where values are at least 10000. Values fall by 100 per unit of distance from its
/// surface.
TestVolume solid(Index3 voxels, const std::function<double(Vec3d)>& distance) {
  return sampled_volume(voxels, {1, 1, 1}, [&](Vec3d p) { return 10000 - 100 * distance(p); });
}

/// The volume's value at a position in voxels; nothing outside of the volume.
std::optional<double> value_at(const TestVolume& volume, Vec3d voxel) {
  const Index3 n = volume.grid.voxels;
  const auto inside = [](double at, int32_t voxels) { return at >= 0 && at <= voxels - 1; };
  if (!inside(voxel.x, n.x) || !inside(voxel.y, n.y) || !inside(voxel.z, n.z)) return {};
  const auto low = [](double at, int32_t voxels) {
    return std::min(static_cast<int32_t>(at), voxels - 2);
  };
  const Index3 cell{low(voxel.x, n.x), low(voxel.y, n.y), low(voxel.z, n.z)};
  const Trilinear f(corners_at(volume, cell.x, cell.y, cell.z));
  return double(f.at({static_cast<float>(voxel.x - cell.x), static_cast<float>(voxel.y - cell.y),
                      static_cast<float>(voxel.z - cell.z)})
                    .value);
}

class CapsGpu : public RendererTest {
 protected:
  void prepare() override {
    settings_.kind = SplatKind::exact;
    settings_.isosurfaces = {{10000, {0.85f, 0.8f, 0.7f}, 1}};
    settings_.clip_caps = true;
  }

  void show(const TestVolume& volume, bool orthographic = true) {
    show_volume(*renderer_, volume, 8000, 12000);
    camera_ = default_camera(volume.grid, 1, orthographic);
    camera_.azimuth = camera_.elevation = 0;  // looks along +y
  }

  Image draw(const std::string& name, bool still = false) {
    return draw_and_keep(settings_, camera_, kSize, "caps-" + name, still);
  }

  std::vector<SurfacePixel> pixels() { return renderer_->read_surface().value(); }

  int cap_pixels() {
    const auto all = pixels();
    return static_cast<int>(
        std::count_if(all.begin(), all.end(), [](const auto& pixel) { return pixel.cap; }));
  }

  /// The area of all caps that face an orthographic camera, in world units.
  double cap_area() {
    const double px = 2 * camera_frame(camera_).half_height(1) / kSize;
    return cap_pixels() * px * px;
  }

  /// Where the ray of a pixel (y upwards) meets the plane, in the world.
  Vec3d on_plane(int x, int y, const Plane& plane) {
    const CameraFrame frame = camera_frame(camera_);
    const double px = 2 * frame.half_height(1) / kSize;
    const Vec3d aside =
        frame.right * ((x + 0.5 - 0.5 * kSize) * px) + frame.up * ((y + 0.5 - 0.5 * kSize) * px);
    const Vec3d origin = frame.orthographic ? frame.eye + aside : frame.eye;
    const Vec3d ray = frame.orthographic ? frame.forward : frame.forward + aside;
    return origin + ray * ((plane.offset - dot(plane.normal, origin)) / dot(plane.normal, ray));
  }

  struct Comparison {
    int caps = 0;       // pixels that should have a cap
    int differing = 0;  // pixels with a cap that should have none, or without
    double depth = 0;   // largest difference of caps
  };

  /// Compares each pixel with the volume's value on the plane, which is the only clip plane. Values
  /// nearer to the isovalue than `tolerance` may count as inside or outside.
  Comparison compare(const TestVolume& volume, const Plane& plane, double tolerance) {
    const auto found = pixels();
    const CameraFrame frame = camera_frame(camera_);
    const Matrix3d dual = volume.grid.dual_edges();
    Comparison c;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const Vec3d at = on_plane(x, y, plane);
        const auto value = value_at(volume, multiply_transposed(dual, at - volume.grid.origin));
        const bool is_inside = value && *value >= 10000;
        c.caps += is_inside;
        const auto& pixel = found[size_t(y) * kSize + size_t(x)];
        if (pixel.cap) {
          const double depth = dot(at - frame.eye, frame.forward);
          c.depth = std::max(c.depth, std::abs(double(pixel.depth) - depth));
        }
        c.differing += pixel.cap != is_inside && !(value && std::abs(*value - 10000) < tolerance);
      }
    }
    return c;
  }

  RenderSettings settings_;
  Camera camera_;
};

TEST_F(CapsGpu, ABallIsCutInADisc) {
  constexpr double kRadius = 18;
  const Vec3d centre{24, 24, 24};
  show(solid({49, 49, 49}, [&](Vec3d p) { return length(p - centre) - kRadius; }));
  constexpr double kTolerance[] = {0.05, 0.01, 0.005};
  for (const SplatKind kind : kKinds) {
    settings_.kind = kind;
    const std::string name = kKindNames[static_cast<int>(kind)];
    for (const double from_centre : {-12.0, -0.3, 9.0}) {
      settings_.clip_box_low = {0, (24 + from_centre) / 48, 0};
      draw("ball-" + name);
      const double area = kPi * (kRadius * kRadius - from_centre * from_centre);
      EXPECT_NEAR(cap_area() / area, 1, kTolerance[static_cast<int>(kind)])
          << name << " at " << from_centre;
    }
    settings_.clip_box_low = {0, 43.0 / 48, 0};  // beyond the ball
    draw("ball-beyond");
    EXPECT_EQ(cap_pixels(), 0) << name;
  }
}

TEST_F(CapsGpu, AShellIsCutInARingAndATorusInTwoDiscs) {
  const Vec3d centre{24, 24, 24};
  show(solid({49, 49, 49}, [&](Vec3d p) { return std::abs(length(p - centre) - 16) - 2.5; }));
  settings_.clip_box_low = {0, 0.5, 0};
  draw("shell");
  EXPECT_NEAR(cap_area() / (kPi * (18.5 * 18.5 - 13.5 * 13.5)), 1, 0.01);
  settings_.clip_box_low = {0, 8.0 / 48, 0};  // above the hollow: a disc
  draw("shell-top");
  EXPECT_NEAR(cap_area() / (kPi * (18.5 * 18.5 - 16 * 16)), 1, 0.02);

  show(solid({49, 49, 25}, [&](Vec3d p) {
    const double across = std::hypot(p.x - 24, p.y - 24) - 15;
    return std::hypot(across, p.z - 12) - 5;
  }));
  settings_.clip_box_low = {0, 0.5, 0};
  draw("torus");
  EXPECT_NEAR(cap_area() / (2 * kPi * 25), 1, 0.01);
  settings_.clip_box_low = {0.5, 0, 0};  // seen edge-on
  draw("torus-beside");
  EXPECT_EQ(cap_pixels(), 0);
}

/// Tubes of a bent shape, which end within the volume.
double labyrinth(Vec3d p, Vec3d centre, double radius) {
  const Vec3d q = p * 0.35;
  const double wave =
      std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
  return std::max(4 * wave, length(p - centre) - radius);
}

TEST_F(CapsGpu, EachPixelAgreesWithTheValuesOnAnObliquePlane) {
  const Vec3d centre{30, 30, 30};
  const TestVolume volume = solid({61, 61, 61}, [&](Vec3d p) { return labyrinth(p, centre, 27); });
  for (const bool orthographic : {true, false}) {
    show(volume, orthographic);
    camera_.azimuth = 25;
    camera_.elevation = 15;
    camera_.distance *= 0.8;
    const Plane plane{{0.36, 0.8, -0.48}, 20};
    settings_.clip_planes = {plane};
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
      settings_.kind = kind;
      const std::string name = kKindNames[static_cast<int>(kind)];
      draw("labyrinth-" + name + (orthographic ? "-orthographic" : ""));
      // Samples have 9 bits per corner: values of a cell are rounded by up to a thousandth of its
      // span.
      const Comparison c = compare(volume, plane, 5);
      EXPECT_GT(c.caps, 8000);
      EXPECT_LE(c.differing, kind == SplatKind::exact ? 5 : c.caps / 100) << name;
      EXPECT_LT(c.depth, 1e-3) << name;
    }
  }
}

TEST_F(CapsGpu, EachPixelAgreesInShearedGrids) {
  const Vec3d centre{120, -80, 40};
  const TestVolume volume = sampled_volume(
      grid_about(centre, 22, {1, 0.5, 0.1, 0.2, 0.8, -0.4, -0.1, 0.3, 0.9}, {1, 1.3, 0.9}),
      [&](Vec3d p) { return 10000 - 100 * labyrinth(p, centre, 20); });
  show(volume, /*orthographic=*/false);
  camera_.elevation = 30;
  const Plane plane{{0.6, 0.8, 0}, dot(Vec3d{0.6, 0.8, 0}, centre) - 3};
  settings_.clip_planes = {plane};
  draw("sheared");
  const Comparison c = compare(volume, plane, 5);
  EXPECT_GT(c.caps, 2000);
  EXPECT_LE(c.differing, 5);
  EXPECT_LT(c.depth, 1e-3);
}

// Columns along the view. No ray meets their walls: all rays leave through the volume's border.
TEST_F(CapsGpu, SolidsThatReachTheBorderAreClosed) {
  const TestVolume volume = solid({49, 25, 49}, [](Vec3d p) {
    const double round = std::hypot(p.x - 16.3, p.z - 30.8) - 11.4;
    const double thin = std::max(std::abs(p.x - 36.2) - 5.3, std::abs(p.z - 17.7) - 13.6);
    return std::min(round, thin);
  });
  show(volume);
  const Plane plane{{0, 1, 0}, 10.4};
  settings_.clip_planes = {plane};
  for (const SplatKind kind : kKinds) {
    settings_.kind = kind;
    const std::string name = kKindNames[static_cast<int>(kind)];
    draw("columns-" + name);
    const Comparison c = compare(volume, plane, 5);
    EXPECT_GT(c.caps, 8000);
    EXPECT_LE(c.differing, 5) << name;
  }
  // In a close-up of a part that contains no surface, the renderer does not know whether the part
  // is solid.
  camera_.target = {16, 10, 31};
  camera_.distance *= 0.1;
  draw("columns-close-up");
  EXPECT_EQ(cap_pixels(), 0);
}

TEST_F(CapsGpu, CellsThatAreTooLargeForPointsGiveStates) {
  renderer_ = std::move(*Renderer::create(/*max_point_size=*/8));
  const Vec3d centre{24, 24, 24};
  const TestVolume volume = solid({49, 49, 49}, [&](Vec3d p) { return length(p - centre) - 18; });
  show(volume, /*orthographic=*/false);
  camera_.target = {40, 24, 24};
  camera_.distance *= 0.15;
  const Plane plane{{0.28, 0.96, 0}, 34};
  settings_.clip_planes = {plane};
  draw("large");
  const Comparison c = compare(volume, plane, 5);
  EXPECT_GT(c.caps, 8000);
  EXPECT_LE(c.differing, 5);
}

TEST_F(CapsGpu, FacesOfTheCapsAreFlat) {
  const Vec3d centre{24, 24, 24};
  show(solid({49, 49, 49}, [&](Vec3d p) { return length(p - centre) - 18; }), false);
  camera_.azimuth = 40;
  camera_.elevation = 30;
  settings_.clip_box_low = {0, 0.5, 0};
  settings_.clip_box_high = {1, 1, 0.6};
  draw("corner", /*still=*/true);
  draw("corner-moving");
  const CameraFrame frame = camera_frame(camera_);
  int across_y = 0, across_z = 0;
  for (const auto& pixel : pixels()) {
    if (!pixel.cap) continue;
    const Vec3d n = frame.right * double(pixel.normal.x) + frame.up * double(pixel.normal.y) -
                    frame.forward * double(pixel.normal.z);
    across_y += length(n - Vec3d{0, -1, 0}) < 1e-3;
    across_z += length(n - Vec3d{0, 0, 1}) < 1e-3;
  }
  EXPECT_GT(across_y, 3000);
  EXPECT_GT(across_z, 3000);
  EXPECT_EQ(across_y + across_z, cap_pixels());
}

// The region between two isovalues is part of the solid of the lower one, whether the next surface
// behind it is that of the lower or of the higher isovalue.
TEST_F(CapsGpu, SeveralSurfacesHaveTheCapsOfTheirSolids) {
  const Vec3d centre{24, 24, 24};
  show(solid({49, 49, 49}, [&](Vec3d p) { return length(p - centre) - 12; }));
  settings_.clip_box_low = {0, 0.5, 0};
  settings_.eye_dome = 0;
  const Isosurface core{10700, {0.9f, 0.1f, 0.1f}, 1}, skin{9300, {0.1f, 0.2f, 0.9f}, 1};
  const auto check = [&](uint32_t of_core, uint32_t of_skin) {
    const auto found = pixels();
    const double px = 2 * camera_frame(camera_).half_height(1) / kSize;
    for (int x = kSize / 2; x < kSize; ++x) {
      const auto& pixel = found[size_t(kSize / 2) * kSize + size_t(x)];
      const double radius = std::hypot((x + 0.5 - kSize / 2) * px, 0.5 * px);
      if (std::abs(radius - 5) < 0.2 || std::abs(radius - 19) < 0.2) continue;
      EXPECT_EQ(pixel.cap, radius < 19) << radius;
      if (!pixel.cap) continue;
      EXPECT_EQ(pixel.isosurface, radius < 5 ? of_core : of_skin) << radius;
    }
  };
  settings_.isosurfaces = {core, skin};
  draw("nested");
  check(0, 1);
  settings_.isosurfaces = {skin, core};
  draw("nested-other-order");
  check(1, 0);

  // In front of the core, translucent skin does not hide the core's cap. Beside the core, the
  // background is visible through the skin.
  settings_.isosurfaces[0].opacity = 0.4f;
  const Image translucent = draw("nested-translucent");
  settings_.isosurfaces[0].opacity = 0;
  const Image alone = draw("nested-core");
  const size_t middle = 4 * (size_t(kSize / 2) * kSize + kSize / 2);
  EXPECT_EQ(translucent.rgba[middle], alone.rgba[middle]);
  const double px = 2 * camera_frame(camera_).half_height(1) / kSize;
  const size_t beside = middle + 4 * static_cast<size_t>(12 / px);
  EXPECT_GT(translucent.rgba[beside + 2], translucent.rgba[beside] + 20);  // blue
  EXPECT_GT(translucent.rgba[beside], 60);                                 // over white
}

TEST_F(CapsGpu, ThereAreNoneWhereNothingIsCut) {
  const Vec3d centre{24, 24, 24};
  // The ball reaches the volume's border. There it stays open.
  const TestVolume volume = solid({49, 25, 49}, [&](Vec3d p) { return length(p - centre) - 18; });
  show(volume);
  camera_.azimuth = 180;
  draw("open");
  EXPECT_EQ(cap_pixels(), 0);
  settings_.clip_box_low = {0.5, 0, 0};  // the border is still open, the face is seen edge-on
  draw("open-beside");
  EXPECT_EQ(cap_pixels(), 0);
  camera_.azimuth = 0;
  settings_.clip_box_low = {0, 0.6, 0};
  settings_.clip_caps = false;
  draw("without");
  EXPECT_EQ(cap_pixels(), 0);
  settings_.clip_caps = true;
  settings_.projected = false;
  draw("unprojected");
  EXPECT_EQ(cap_pixels(), 0);
  // The eye is inside of the part that is shown.
  settings_.projected = true;
  camera_ = default_camera(volume.grid, 1);
  camera_.target = {24, 20, 24};
  camera_.distance = 2;
  draw("inside");
  EXPECT_EQ(cap_pixels(), 0);
}

// Streaming must still fetch the surfaces behind caps, since caps follow from them.
TEST_F(CapsGpu, OcclusionQueriesIgnoreThem) {
  const Vec3d centre{24, 24, 24};
  show(solid({49, 49, 49}, [&](Vec3d p) { return length(p - centre) - 18; }));
  settings_.clip_box_low = {0, 0.4, 0};
  const auto visible = [&] {
    draw("query");
    const ChunkHandle handle = 0;
    EXPECT_TRUE(renderer_->begin_occlusion_query({&handle, 1}, 0));
    glFinish();
    return renderer_->take_occlusion_query().value().at(0).visible;
  };
  const RegionMask with = visible();
  EXPECT_GT(cap_pixels(), 10000);
  settings_.clip_caps = false;
  EXPECT_EQ(visible(), with);
}

TEST_F(CapsGpu, APickFindsTheCap) {
  const Vec3d centre{30, 30, 30};
  show(solid({61, 61, 61}, [&](Vec3d p) { return labyrinth(p, centre, 27); }), false);
  camera_.azimuth = 25;
  const Plane plane{{0.6, 0.8, 0}, 38};
  settings_.clip_planes = {plane};
  draw("pick");
  const auto found = pixels();
  int caps = 0, differing = 0;
  for (int y = 5; y < kSize; y += 6) {
    for (int x = 5; x < kSize; x += 6) {
      const auto pick = renderer_->pick(x + 0.5, kSize - y - 0.5, kSize, kSize).value();
      const auto& pixel = found[size_t(y) * kSize + size_t(x)];
      differing += pixel.cap != (pick && pick->cap);
      if (!pick || !pick->cap || !pixel.cap) continue;
      ++caps;
      EXPECT_LT(length(pick->position - on_plane(x, y, plane)), 1e-6);
      EXPECT_LT(length(pick->normal + plane.normal), 1e-9);
      EXPECT_GT(pick->to_next, 0);
    }
  }
  EXPECT_GT(caps, 100);
  EXPECT_LE(differing, 1);
}

}  // namespace
}  // namespace isosplat::render
