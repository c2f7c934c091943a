// Grids whose axes are not perpendicular, compared with the analytic surface, and with the same
// field on a perpendicular grid. Each comparison states its thresholds.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <optional>

#include "native/headless/draw_image.h"
#include "native/headless/ray_caster.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr Vec3d kCentre{120, -80, 40};
constexpr double kRadius = 20;
constexpr int kSize = 400;

struct NamedGrid {
  const char* name;
  Matrix3d axes;  // columns, of any length
  Vec3d spacing;
};

// Sheared like a CT with gantry tilt (18.5°); oblique and rotated in all planes (up to 44°); and
// left-handed.
const NamedGrid kSheared[] = {
    {"gantry", {1, 0, 0, 0, 0.948, 0, 0, 0.317, 1}, {1, 1, 2.4}},
    {"steep", {1, 0.6, 0.2, 0.2, 0.8, -0.5, -0.1, 0.4, 0.9}, {1, 1.3, 0.9}},
    {"mirrored", {-1, 0.5, 0, 0, 1, 0.4, 0.3, 0, 1}, {1.2, 1, 1.1}},
};
const NamedGrid kPerpendicular{"perpendicular", kIdentity3, {1, 1, 1}};

constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::exact};
constexpr const char* kKindNames[] = {"quad", "ellipse", "exact"};

/// 100 times the distance from the centre: the isosurface of isovalue 100 r is a sphere of radius
/// r.
TestVolume ball(const NamedGrid& grid) {
  return sampled_volume(grid_about(kCentre, kRadius, grid.axes, grid.spacing),
                        [](Vec3d p) { return 100 * length(p - kCentre); });
}

Vec3d pixel_ray(const CameraFrame& frame, int x, int y) {
  const double px = 2 * frame.tan_half_field_of_view / kSize;
  return frame.forward + frame.right * ((x + 0.5 - 0.5 * kSize) * px) +
         frame.up * ((y + 0.5 - 0.5 * kSize) * px);
}

struct Hit {
  double depth = 0;
  Vec3d normal;
};

/// The first or last intersection of the pixel's ray with the sphere.
std::optional<Hit> sphere_hit(const CameraFrame& frame, int x, int y, bool last = false) {
  const Vec3d ray = pixel_ray(frame, x, y), from = frame.eye - kCentre;
  const double a = dot(ray, ray), b = dot(ray, from), c = dot(from, from) - kRadius * kRadius;
  const double root = b * b - a * c;
  if (root < 0) return std::nullopt;
  const double t = (-b + (last ? 1 : -1) * std::sqrt(root)) / a;
  return Hit{t, (from + ray * t) * (1 / kRadius)};
}

class ShearGpu : public RendererTest {
 protected:
  void prepare() override {
    camera_.target = kCentre;
    camera_.distance = 200;  // so that cells are small enough to be squares and ellipses
    settings_.isosurfaces = {{100 * kRadius, {0.85f, 0.8f, 0.7f}, 1}};
  }

  void use(Result<std::unique_ptr<Renderer>> renderer) {
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
  }

  Image draw(const TestVolume& volume, uint32_t level = 0) {
    show_volume(*renderer_, volume, 100 * kRadius, 100 * kRadius, level);
    renderer_->set_camera(camera_);
    renderer_->set_settings(settings_);
    auto image = draw_image(*renderer_, kSize, kSize);
    EXPECT_TRUE(image) << image.error().message;
    return std::move(*image);
  }

  Vec3d world_normal(const SurfacePixel& pixel) const {
    const CameraFrame frame = camera_frame(camera_);
    return frame.right * double(pixel.normal.x) + frame.up * double(pixel.normal.y) -
           frame.forward * double(pixel.normal.z);
  }

  struct Difference {
    int truth = 0, outline = 0, holes = 0;  // pixels
    double depth = 0;                       // mean, world units (a cell is about one)
    double normal = 0, worst_normal = 0;    // degrees
  };

  /// Compares the last picture with the true sphere. Holes and the worst normal do not count near
  /// the outline.
  Difference against_the_sphere() const {
    const auto pixels = renderer_->read_surface().value();
    const CameraFrame frame = camera_frame(camera_);
    Difference d;
    int both = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto truth = sphere_hit(frame, x, y);
        const auto& ours = pixels[size_t(y) * kSize + size_t(x)];
        const bool covered = ours.hit;
        d.truth += truth.has_value();
        d.outline += truth.has_value() != covered;
        const double facing =
            truth ? -dot(truth->normal, pixel_ray(frame, x, y)) / length(pixel_ray(frame, x, y))
                  : 0;
        d.holes += facing > 0.2 && !covered;
        if (!truth || !covered) continue;
        ++both;
        d.depth += std::abs(truth->depth - double(ours.depth));
        const double angle =
            std::acos(std::min(1.0, std::abs(dot(world_normal(ours), truth->normal)))) * 180 /
            3.14159265;
        d.normal += angle;
        if (facing > 0.3) d.worst_normal = std::max(d.worst_normal, angle);
      }
    }
    d.depth /= std::max(1, both);
    d.normal /= std::max(1, both);
    return d;
  }

  Camera camera_;
  RenderSettings settings_;
};

// Largest share of differing pixels at the outline, mean depth error in world units, mean and worst
// normal error in degrees. A perpendicular grid meets the same limits.
struct Limits {
  double outline, depth, normal, worst_normal;
};
constexpr Limits kLimits[] = {{0.04, 0.3, 3.5, 15}, {0.006, 0.06, 2, 6}, {0.004, 0.06, 2, 6}};

TEST_F(ShearGpu, EveryKindDrawsTheTrueSphereOnEveryGrid) {
  for (const double azimuth : {30.0, 155.0}) {
    camera_.azimuth = azimuth;
    camera_.elevation = azimuth / 4;
    for (const NamedGrid* grid : {&kPerpendicular, &kSheared[0], &kSheared[1], &kSheared[2]}) {
      const TestVolume volume = ball(*grid);
      for (const SplatKind kind : kKinds) {
        settings_.kind = kind;
        const char* name = kKindNames[static_cast<int>(kind)];
        SCOPED_TRACE(std::string(grid->name) + ", " + name);
        keep(draw(volume), std::string("shear-") + grid->name + "-" + name);
        const Difference d = against_the_sphere();
        if (std::getenv("ISOSPLAT_TEST_PICTURES")) {
          std::printf("%-14s %-8s outline %.4f holes %d depth %.4f normal %.3f worst %.2f\n",
                      grid->name, name, double(d.outline) / d.truth, d.holes, d.depth, d.normal,
                      d.worst_normal);
        }
        const Limits& limits = kLimits[static_cast<int>(kind)];
        EXPECT_GT(d.truth, 15000);
        EXPECT_EQ(d.holes, 0);
        EXPECT_LT(double(d.outline) / d.truth, limits.outline);
        EXPECT_LT(d.depth, limits.depth);
        EXPECT_LT(d.normal, limits.normal);
        EXPECT_LT(d.worst_normal, limits.worst_normal);
      }
    }
  }
}

// The camera is so near that cells exceed the usual limit of point sizes. They are drawn both as
// points and as triangles.
TEST_F(ShearGpu, CloseUpsAreTheSameAsPointsAndAsTriangles) {
  camera_.distance = 32;
  std::vector<std::vector<SurfacePixel>> as_points;
  for (const float max_point_size : {1024.0f, 16.0f}) {
    use(Renderer::create(max_point_size));
    auto points = as_points.begin();
    for (const NamedGrid& grid : kSheared) {
      const TestVolume volume = ball(grid);
      for (const SplatKind kind : kKinds) {
        settings_.kind = kind;
        const std::string name = std::string(grid.name) + "-" + kKindNames[static_cast<int>(kind)];
        SCOPED_TRACE(name);
        const Image image = draw(volume);
        const auto pixels = renderer_->read_surface().value();
        const Difference d = against_the_sphere();
        EXPECT_EQ(d.holes, 0);
        EXPECT_LT(d.depth, 0.06);
        EXPECT_LT(d.normal, 2);
        if (max_point_size > 16) {
          keep(image, "shear-near-" + name);
          as_points.push_back(pixels);
          continue;
        }
        int differing = 0;
        for (size_t i = 0; i < pixels.size(); ++i) {
          differing += (*points)[i].hit != pixels[i].hit ||
                       std::abs((*points)[i].depth - pixels[i].depth) > 0.01f;
        }
        ++points;
        EXPECT_LT(differing, kSize * kSize / 2000);
      }
    }
  }
}

/// A ball with lumps, and with steep and flat sides, without any symmetry.
TestVolume lumps(const NamedGrid& grid) {
  return sampled_volume(grid_about(kCentre, kRadius + 3, grid.axes, grid.spacing), [](Vec3d p) {
    const Vec3d d = p - kCentre;
    return 100 * length(d) + 60 * std::sin(0.31 * d.x + 1) * std::cos(0.27 * d.y) + 8 * d.z +
           50 * std::sin(0.4 * d.z - 0.2 * d.x);
  });
}

// A field and its copy on a perpendicular grid have the same lighting and colouring.
TEST_F(ShearGpu, LooksLikeItsCopyOnAPerpendicularGrid) {
  settings_.colour_low = 60;
  settings_.colour_high = 140;  // quantized values per world unit
  // Mean difference of 255, and the largest share of values that differ by more than 24 (outlines).
  constexpr double kMean[] = {2.5, 1, 1}, kShare[] = {0.03, 0.01, 0.01};
  for (const ColourBy colour_by : {ColourBy::isosurface, ColourBy::gradient}) {
    settings_.colour_by = colour_by;
    for (const SplatKind kind : kKinds) {
      settings_.kind = kind;
      const Image copy = draw(lumps(kPerpendicular));
      for (const NamedGrid& grid : kSheared) {
        const std::string name = std::string(grid.name) + "-" + kKindNames[static_cast<int>(kind)] +
                                 (colour_by == ColourBy::gradient ? "-gradient" : "");
        SCOPED_TRACE(name);
        const Image image = draw(lumps(grid));
        keep(image, "shear-lumps-" + name);
        double sum = 0, large = 0;
        for (size_t i = 0; i < image.rgba.size(); ++i) {
          const int difference = std::abs(int{image.rgba[i]} - int{copy.rgba[i]});
          sum += difference;
          large += difference > 24;
        }
        const auto values = double(image.rgba.size());
        if (std::getenv("ISOSPLAT_TEST_PICTURES")) {
          std::printf("%-28s mean %.3f share %.4f\n", name.c_str(), sum / values, large / values);
        }
        EXPECT_LT(sum / values, kMean[static_cast<int>(kind)]);
        EXPECT_LT(large / values, kShare[static_cast<int>(kind)]);
      }
    }
  }
}

// A clip plane (in world coordinates) and a clip box (in fractions of the volume) cut at the right
// positions.
TEST_F(ShearGpu, ClipPlanesAndBoxesCutAtTheStatedPositions) {
  const Vec3d n{-0.6, 0.64, -0.48};  // cuts away the part nearest to the eye
  for (const NamedGrid& named : kSheared) {
    const TestVolume volume = ball(named);
    const VolumeGrid& grid = volume.grid;
    const auto fraction = [&](Vec3d p) {
      const Vec3d index = multiply_transposed(grid.dual_edges(), p - grid.origin);
      return index.x / (grid.voxels.x - 1);
    };
    for (const bool box : {false, true}) {
      settings_.clip_planes.clear();
      settings_.clip_box_high.x = 1;
      if (box) {
        settings_.clip_box_high.x = 0.6;
      } else {
        settings_.clip_planes = {{n, dot(n, kCentre) - 5}};
      }
      const auto keeps = [&](Vec3d p) {
        return box ? fraction(p) <= 0.6 : dot(n, p - kCentre) >= -5;
      };
      for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
        settings_.kind = kind;
        SCOPED_TRACE(std::string(named.name) + (box ? ", box, " : ", plane, ") +
                     kKindNames[static_cast<int>(kind)]);
        draw(volume);
        const auto pixels = renderer_->read_surface().value();
        const CameraFrame frame = camera_frame(camera_);
        int differing = 0, cut = 0, seen = 0;
        for (int y = 0; y < kSize; ++y) {
          for (int x = 0; x < kSize; ++x) {
            std::optional<Hit> truth;
            for (const bool last : {false, true}) {
              const auto hit = sphere_hit(frame, x, y, last);
              const bool is_kept = hit && keeps(frame.eye + pixel_ray(frame, x, y) * hit->depth);
              cut += hit && !last && !is_kept;
              if (is_kept && !truth) truth = hit;
            }
            const auto& ours = pixels[size_t(y) * kSize + size_t(x)];
            seen += truth.has_value();
            differing += truth.has_value() != ours.hit ||
                         (truth && std::abs(truth->depth - double(ours.depth)) > 0.3);
          }
        }
        EXPECT_GT(seen, 5000);
        EXPECT_GT(cut, 100);
        EXPECT_LT(differing, seen / 60);  // pixels at outlines and at the cut
      }
    }
  }
}

TEST_F(ShearGpu, CoarseLevelsHaveNoHoles) {
  for (const NamedGrid& grid : kSheared) {
    const TestVolume volume = ball(grid);
    for (const SplatKind kind : kKinds) {
      settings_.kind = kind;
      SCOPED_TRACE(std::string(grid.name) + ", " + kKindNames[static_cast<int>(kind)]);
      draw(volume, 1);
      const Difference d = against_the_sphere();
      EXPECT_EQ(d.holes, 0);
      EXPECT_LT(double(d.outline) / d.truth, 0.15);
    }
  }
}

// Compares the ray caster, the reference of other tests, with the analytic sphere.
TEST_F(ShearGpu, TheRayCasterFindsTheSphere) {
  const CameraFrame frame = camera_frame(camera_);
  for (const NamedGrid& grid : kSheared) {
    SCOPED_TRACE(grid.name);
    const TestVolume volume = ball(grid);
    const RayCaster caster(volume.grid, volume.quantized_values, false);
    int hits = 0, differing = 0;
    for (int y = 0; y < kSize; y += 5) {
      for (int x = 0; x < kSize; x += 5) {
        const auto truth = sphere_hit(frame, x, y);
        const auto hit = caster.cast(camera_, kSize, kSize, x, y, 100 * kRadius);
        differing += truth.has_value() != hit.has_value();
        if (!truth || !hit) continue;
        ++hits;
        // For rays that graze the surface, a small error of position is a large one in depth.
        const double facing =
            std::abs(dot(truth->normal, pixel_ray(frame, x, y))) / length(pixel_ray(frame, x, y));
        EXPECT_LT(std::abs(hit->depth - truth->depth) * facing, 0.06);
        EXPECT_GT(dot(hit->normal, truth->normal), std::cos(6 * 3.14159265 / 180));
        EXPECT_NEAR(hit->gradient, 100, 8);
      }
    }
    EXPECT_GT(hits, 500);
    EXPECT_LE(differing, 8);
  }
}

// Occlusion queries report as visible the regions that the pixels show.
TEST_F(ShearGpu, OcclusionQueriesFindTheVisibleRegions) {
  settings_.kind = SplatKind::exact;
  constexpr uint32_t kLevel = 0;
  constexpr int kMin = 40;
  for (const NamedGrid& named : kSheared) {
    SCOPED_TRACE(named.name);
    const TestVolume volume = ball(named);
    const VolumeGrid& grid = volume.grid;
    ASSERT_EQ(level_grid(grid.voxels, kLevel).block_count(), 1u);
    draw(volume, kLevel);
    const ChunkHandle handle = 0;
    ASSERT_TRUE(renderer_->begin_occlusion_query({&handle, 1}, kMin));
    std::optional<std::vector<ChunkVisibility>> answer;
    while (!answer) answer = renderer_->take_occlusion_query();
    const auto pixels = renderer_->read_surface().value();
    const CameraFrame frame = camera_frame(camera_);
    int counts[512] = {};
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto& pixel = pixels[size_t(y) * kSize + size_t(x)];
        if (!pixel.hit) continue;
        const Vec3d p = frame.eye + pixel_ray(frame, x, y) * double(pixel.depth);
        const Vec3d index = multiply_transposed(grid.dual_edges(), p - grid.origin) * 0.125;
        ++counts[int(index.x) + 8 * int(index.y) + 64 * int(index.z)];
      }
    }
    int seen = 0, hidden = 0;
    for (int bit = 0; bit < 512; ++bit) {
      const bool is_seen = answer->at(0).visible.contains({bit % 8, bit / 8 % 8, bit / 64});
      if (is_seen) {
        EXPECT_GE(counts[bit], kMin / 2) << "region " << bit;
      } else {
        EXPECT_LE(counts[bit], kMin * 5 / 4) << "region " << bit;
      }
      ++(is_seen ? seen : hidden);
    }
    EXPECT_GT(seen, 12);
    EXPECT_GT(hidden, 300);
  }
}

}  // namespace
}  // namespace isosplat::render
