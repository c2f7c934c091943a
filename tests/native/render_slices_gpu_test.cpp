// Slices, compared pixel by pixel with the volume's values in their planes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "native/headless/draw_image.h"
#include "shared/core/sampling/trilinear.h"
#include "shared/render/settings/colour_maps.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 320;
using Slice = SurfacePixel::Slice;

/// Waves, between 0 and 2000.
double waves(Vec3d p) {
  return 1000 + 500 * std::sin(0.31 * p.x + 0.1 * p.z) + 500 * std::cos(0.23 * p.y - 0.17 * p.z);
}

/// A level with the cells that are active for some value of a range. The test computes the expected
/// values from them.
struct LevelOfVolume {
  TestVolume volume;  ///< with the voxels of the level
  uint32_t level = 0;
  double low = 0, high = 0;

  LevelOfVolume(const TestVolume& finest, uint32_t level_, double low_, double high_)
      : volume(finest), level(level_), low(low_), high(high_) {
    for (uint32_t i = 0; i < level; ++i) volume = coarser_volume(volume);
  }
};

class SlicesGpu : public RendererTest {
 protected:
  void prepare() override {
    settings_.slice_low = 0;
    settings_.slice_high = 2000;
    settings_.eye_dome = 0;
  }

  void show(const TestVolume& volume, bool orthographic = false) {
    volume_ = volume;
    levels_.clear();
    renderer_->set_volume(volume.grid, volume.mapping);
    camera_ = default_camera(volume.grid, 1, orthographic);
    camera_.azimuth = 25;
    camera_.elevation = 20;
  }

  /// Adds the cells of a level that are active for some value of [low, high]; they are resident,
  /// and not visible.
  void add(uint32_t level, double low, double high) {
    const LevelGrid grid = level_grid(volume_.grid.voxels, level);
    for (int32_t i = 0; i < static_cast<int32_t>(grid.block_count()); ++i) {
      const BlockKey block{level,
                           {i % grid.blocks.x, i / grid.blocks.x % grid.blocks.y,
                            i / (grid.blocks.x * grid.blocks.y)}};
      const auto samples = block_samples(volume_, block, low, high);
      ASSERT_TRUE(renderer_->add_chunk(next_handle_++, block, samples));
    }
    levels_.emplace_back(volume_, level, low, high);
  }

  Image draw(const std::string& name, bool still = false) {
    return draw_and_keep(settings_, camera_, kSize, "slices-" + name, still);
  }

  std::vector<SurfacePixel> pixels() { return renderer_->read_surface().value(); }

  int count(Slice shown) {
    const auto all = pixels();
    return static_cast<int>(std::count_if(
        all.begin(), all.end(), [shown](const auto& p) { return p.hit && p.slice == shown; }));
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

  Vec3d voxel_of(Vec3d at) {
    return multiply_transposed(volume_.grid.dual_edges(), at - volume_.grid.origin);
  }

  struct Expected {
    double value = 0, span = 0;
    bool is_known = false;  ///< some level has a cell there
    bool is_near_face = false;
  };

  /// The value of the finest level that has a cell at a position in voxels.
  Expected expected_at(Vec3d voxel) {
    Expected e;
    uint32_t finest = std::numeric_limits<uint32_t>::max();
    for (const LevelOfVolume& of : levels_) {
      const Vec3d at = voxel * std::ldexp(1.0, -static_cast<int>(of.level));
      const LevelGrid grid = level_grid(volume_.grid.voxels, of.level);
      const auto cell_of = [](double p, int32_t cells) {
        return std::clamp(static_cast<int32_t>(std::floor(p)), 0, cells - 1);
      };
      const Index3 cell{cell_of(at.x, grid.cells.x), cell_of(at.y, grid.cells.y),
                        cell_of(at.z, grid.cells.z)};
      const Vec3d p{at.x - cell.x, at.y - cell.y, at.z - cell.z};
      for (const double q : {p.x, p.y, p.z}) e.is_near_face |= std::min(q, 1 - q) < 0.01;
      const Index3 block{cell.x / kBlockCells, cell.y / kBlockCells, cell.z / kBlockCells};
      const Index3 in_block{cell.x % kBlockCells, cell.y % kBlockCells, cell.z % kBlockCells};
      const auto& samples = samples_of({of.level, block}, of.low, of.high);
      const auto found = std::find_if(samples.begin(), samples.end(),
                                      [&](const auto& sample) { return sample.cell == in_block; });
      if (found == samples.end() || of.level >= finest) continue;
      finest = of.level;
      CellCorners corners = corners_at(of.volume, cell.x, cell.y, cell.z);
      // The averages at the corners of a coarse cell may lie outside of its interval; samples clamp
      // them to it.
      for (auto& corner : corners) {
        corner = std::clamp(corner, found->interval.min, found->interval.max);
      }
      const Trilinear f(corners);
      e.is_known = true;
      e.span = double(found->interval.max - found->interval.min);
      e.value = double(
          f.at({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}).value);
    }
    return e;
  }

  /// The samples of a block, from which the test finds the active cells.
  const std::vector<UnpackedSample>& samples_of(BlockKey block, double low, double high) {
    for (const auto& [key, samples] : unpacked_) {
      if (key == block) return samples;
    }
    std::vector<UnpackedSample> samples;
    for (const PackedSample& packed : block_samples(volume_, block, low, high)) {
      samples.push_back(unpack_sample(packed));
    }
    unpacked_.emplace_back(block, std::move(samples));
    return unpacked_.back().second;
  }

  struct Comparison {
    int values = 0, no_data = 0;
    int differing = 0;       // pixels with missing or surplus values
    double error = 0;        // largest difference, in the volume's values
    double depth_error = 0;  // in world units
  };

  /// Compares each pixel of a slice that nothing hides.
  Comparison compare(const Plane& plane) {
    unpacked_.clear();
    const auto found = pixels();
    const CameraFrame frame = camera_frame(camera_);
    const Index3 n = volume_.grid.voxels;
    Comparison c;
    for (int y = 0; y < kSize; y += 2) {
      for (int x = 0; x < kSize; x += 2) {
        const Vec3d at = on_plane(x, y, plane);
        const Vec3d voxel = voxel_of(at);
        const auto margin = [](double p, int32_t voxels) { return std::min(p, voxels - 1 - p); };
        const double inside =
            std::min({margin(voxel.x, n.x), margin(voxel.y, n.y), margin(voxel.z, n.z)});
        if (std::abs(inside) < 0.05) continue;
        const auto& pixel = found[size_t(y) * kSize + size_t(x)];
        if (inside < 0) {
          c.differing += pixel.hit;
          continue;
        }
        const Expected e = expected_at(voxel);
        const bool shows_value = pixel.hit && pixel.slice == Slice::values;
        if (shows_value != e.is_known) {
          c.differing += !e.is_near_face;
          continue;
        }
        if (!shows_value) {
          ++c.no_data;
          continue;
        }
        ++c.values;
        if (e.is_near_face && levels_.size() > 1) continue;  // may show the other level's value
        // Samples have the precision of 1/512 of the span, and pixels have 16 bits for the position
        // in the colour map.
        const double rounding = e.span / 512 + 2000.0 / 65535;
        c.error = std::max(c.error, std::abs(double(pixel.scalar) * 2000 - e.value) - rounding);
        const double depth = dot(at - frame.eye, frame.forward);
        c.depth_error = std::max(c.depth_error, std::abs(double(pixel.depth) - depth));
      }
    }
    return c;
  }

  RenderSettings settings_;
  Camera camera_;
  TestVolume volume_;
  std::vector<LevelOfVolume> levels_;
  std::vector<std::pair<BlockKey, std::vector<UnpackedSample>>> unpacked_;
  ChunkHandle next_handle_ = 0;

  void expect_values_everywhere(const Plane& plane) {
    const Comparison c = compare(plane);
    EXPECT_GT(c.values, 1000);
    EXPECT_LE(c.differing, 2);
    EXPECT_LT(c.error, 0.5);
    EXPECT_LT(c.depth_error, 0.02);
  }
};

TEST_F(SlicesGpu, EachPixelShowsTheValueInAnyPlane) {
  const TestVolume volume = sampled_volume({75, 40, 52}, {1, 1, 1}, waves);
  const Plane planes[] = {{{1, 0, 0}, 37}, {{0, 1, 0}, 20.3}, {{0.36, 0.8, -0.48}, 10}};
  for (const bool orthographic : {false, true}) {
    show(volume, orthographic);
    add(0, 0, 2000);
    for (const Plane& plane : planes) {
      settings_.slices = {plane};
      draw("planes");
      expect_values_everywhere(plane);
    }
  }
}

TEST_F(SlicesGpu, EachPixelShowsTheValueInAShearedGrid) {
  const Vec3d centre{120, -80, 40};
  show(sampled_volume(
      grid_about(centre, 22, {1, 0.5, 0.1, 0.2, 0.8, -0.4, -0.1, 0.3, 0.9}, {1, 1.3, 0.9}), waves));
  add(0, 0, 2000);
  const Vec3d normal{3, 4, 1};  // of any length
  const Plane plane{normal, dot(normal, centre) - 8};
  settings_.slices = {plane};
  draw("sheared");
  expect_values_everywhere(plane);
}

TEST_F(SlicesGpu, ThePatternShowsWhereThereAreNoCells) {
  show(sampled_volume({60, 60, 60}, {1, 1, 1}, waves));
  add(0, 900, 1100);
  const Plane plane{{0.6, 0.8, 0}, 40};
  settings_.slices = {plane};
  draw("no-data");
  const Comparison c = compare(plane);
  EXPECT_GT(c.values, 500);
  EXPECT_GT(c.no_data, 1000);
  EXPECT_LE(c.differing, 2);
  EXPECT_LT(c.error, 0.5);
  // There are lines, and nothing between them.
  EXPECT_GT(count(Slice::no_data), 500);
  EXPECT_LT(count(Slice::no_data), 4 * c.no_data / 3);
}

TEST_F(SlicesGpu, FinerLevelsReplaceCoarserOnes) {
  // 75 voxels: coarse cells reach beyond the volume, where slices end.
  show(sampled_volume({75, 75, 75}, {1, 1, 2}, waves));
  add(0, 900, 1000);
  add(2, 0, 2000);
  add(1, 600, 1000);
  const Plane plane{{0.28, 0.96, 0}, 45};
  settings_.slices = {plane};
  draw("levels");
  const Comparison c = compare(plane);
  EXPECT_GT(c.values, 5000);
  EXPECT_LE(c.differing, 5);
  EXPECT_LT(c.error, 0.5);
}

TEST_F(SlicesGpu, LargeCellsAreDrawnAsTriangles) {
  renderer_ = std::move(*Renderer::create(/*max_point_size=*/8));
  show(sampled_volume({60, 60, 60}, {1, 1, 1}, waves));
  add(0, 0, 2000);
  camera_.distance *= 0.15;
  const Plane plane{{0.28, 0.96, 0}, 34};
  settings_.slices = {plane};
  draw("large");
  const Comparison c = compare(plane);
  EXPECT_GT(c.values, 5000);
  EXPECT_LE(c.differing, 2);
  EXPECT_LT(c.error, 0.5);
}

/// A ball of radius 15, whose values fall from its middle outwards.
TestVolume ball() {
  return sampled_volume({49, 49, 49}, {1, 1, 1}, [](Vec3d p) {
    return 2000 - 40 * length(p - Vec3d{24, 24, 24});
  });
}

TEST_F(SlicesGpu, TheyAreInOneDepthOrderWithSurfacesAndEachOther) {
  settings_.isosurfaces = {{1400, {0.85f, 0.8f, 0.7f}, 1}};  // radius 15
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    show(ball());
    add(0, 0, 2000);
    const ChunkHandle handle = next_handle_ - 1;
    renderer_->set_visible({&handle, 1});
    camera_.azimuth = camera_.elevation = 0;  // looks along +y
    const size_t middle = size_t(kSize / 2) * kSize + kSize / 2, beside = middle + kSize / 4;
    settings_.slices = {{{0, 1, 0}, 24}};
    draw("middle");
    EXPECT_EQ(pixels()[middle].slice, Slice::none);  // the ball's front half
    EXPECT_EQ(pixels()[beside].slice, Slice::values);
    settings_.slices = {{{0, 1, 0}, 4}};
    draw("front");
    EXPECT_EQ(pixels()[middle].slice, Slice::values);
    // Where two slices overlap, the nearer one is visible. They meet where x is 24.
    settings_.isosurfaces.clear();
    settings_.slices = {{{0.6, 0.8, 0}, 0.6 * 24 + 0.8 * 24}, {{-0.6, 0.8, 0}, 0.2 * 24}};
    draw("crossing");
    for (const int x : {kSize / 2 - 60, kSize / 2 + 60}) {
      const auto pixel = pixels()[size_t(kSize / 2) * kSize + size_t(x)];
      const CameraFrame frame = camera_frame(camera_);
      const double nearest =
          std::min(dot(on_plane(x, kSize / 2, settings_.slices[0]) - frame.eye, frame.forward),
                   dot(on_plane(x, kSize / 2, settings_.slices[1]) - frame.eye, frame.forward));
      EXPECT_NEAR(double(pixel.depth), nearest, 0.02);
    }
    settings_.isosurfaces = {{1400, {0.85f, 0.8f, 0.7f}, 1}};
  }
}

TEST_F(SlicesGpu, TheClippingCutsThem) {
  show(ball(), /*orthographic=*/true);
  add(0, 0, 2000);
  camera_.azimuth = camera_.elevation = 0;
  settings_.slices = {{{0, 1, 0}, 24}};
  const auto area = [&] {
    const double px = 2 * camera_frame(camera_).half_height(1) / kSize;
    return count(Slice::values) * px * px;
  };
  draw("whole");
  EXPECT_NEAR(area(), 48 * 48, 25);
  settings_.clip_box_low = {0.25, 0, 0};
  settings_.clip_box_high = {1, 1, 0.5};
  draw("clipped");
  EXPECT_NEAR(area(), 36 * 24, 25);
  // If a slice lies in a face of the box, it hides the cap in the same plane.
  settings_.isosurfaces = {{1400, {0.85f, 0.8f, 0.7f}, 1}};
  const ChunkHandle handle = next_handle_ - 1;
  renderer_->set_visible({&handle, 1});
  for (const bool caps : {false, true}) {
    settings_.clip_caps = caps;
    settings_.clip_box_low = {0.25, 0.5, 0};
    draw("in-face");
    EXPECT_NEAR(area(), 36 * 24, 25) << caps;
  }
  settings_.clip_box_low = {0, 0.6, 0};
  draw("cut-away");
  EXPECT_EQ(count(Slice::values), 0);
}

TEST_F(SlicesGpu, ColoursAreThoseOfTheLegend) {
  show(ball());
  add(0, 0, 2000);
  camera_.azimuth = camera_.elevation = 0;
  settings_.slices = {{{0, 1, 0}, 24}};
  const auto check = [&](const std::string& name, double tolerance, auto colour) {
    const Image image = draw(name, name == "still");
    const auto found = pixels();
    int compared = 0;
    for (int y = 20; y < kSize - 20; y += 7) {
      for (int x = 20; x < kSize - 20; x += 7) {
        const auto& pixel = found[size_t(y) * kSize + size_t(x)];
        if (!pixel.hit || pixel.slice != Slice::values) continue;
        const Vec3d voxel = voxel_of(on_plane(x, y, settings_.slices[0]));
        if (length(voxel - Vec3d{24, 24, 24}) < 3) continue;  // the values have a peak
        ++compared;
        const uint8_t* rgba = &image.rgba[4 * (size_t(kSize - 1 - y) * kSize + size_t(x))];
        const Vec3d expected = colour(expected_at(voxel).value);
        EXPECT_NEAR(rgba[0], expected.x, tolerance) << name << " at " << x << ", " << y;
        EXPECT_NEAR(rgba[1], expected.y, tolerance) << name;
        EXPECT_NEAR(rgba[2], expected.z, tolerance) << name;
      }
    }
    EXPECT_GT(compared, 300);
  };
  const auto grey = [](double value) {
    const double level = 255 * value / 2000;
    return Vec3d{level, level, level};
  };
  check("grey", 1.5, grey);
  check("still", 2.5, grey);
  const auto mapped = [](double from, double to) {
    return [=](double value) {
      const double place = std::clamp((value - from) / (to - from), 0.0, 1.0);
      const auto& c = kColourMapTable[0][static_cast<size_t>(std::lround(255 * place))];
      return Vec3d{double(c[0]), double(c[1]), double(c[2])};
    };
  };
  settings_.colour_map = ColourMap::viridis;
  settings_.slices_mapped = true;
  check("mapped", 3, mapped(0, 2000));
  settings_.slices_mapped = false;
  settings_.colour_by = ColourBy::isovalue;
  settings_.colour_low = 500;
  settings_.colour_high = 2000;
  check("of isovalues", 3, mapped(500, 2000));
}

TEST_F(SlicesGpu, TilesShowThemAsTheWholePictureDoes) {
  show(sampled_volume({60, 60, 60}, {1, 1, 1}, waves));
  add(0, 900, 1100);
  add(2, 0, 700);
  settings_.slices = {{{1, 0, 0}, 30}, {{0.36, 0.8, -0.48}, 10}};
  const Image whole = draw("whole-picture");
  ASSERT_TRUE(renderer_->begin_tiles(kSize, kSize));
  constexpr int kTile = 64;
  int differing = 0;
  std::vector<uint8_t> tile(4 * kTile * kTile);
  for (int top = 0; top < kSize; top += kTile) {
    for (int left = 0; left < kSize; left += kTile) {
      ASSERT_TRUE(renderer_->draw_tile(left, top, kTile, kTile, /*pictures=*/1, tile));
      for (int y = 0; y < kTile; ++y) {
        for (int x = 0; x < kTile; ++x) {
          const size_t at = 4 * (size_t(top + y) * kSize + size_t(left + x));
          const size_t in_tile = 4 * (size_t(y) * kTile + size_t(x));
          int most = 0;
          for (size_t i = 0; i < 4; ++i) {
            most = std::max(most, std::abs(int(whole.rgba[at + i]) - int(tile[in_tile + i])));
          }
          differing += most > 2;
        }
      }
    }
  }
  renderer_->end_tiles();
  EXPECT_LE(differing, 20);  // rounding at the edges of cells and lines
}

TEST_F(SlicesGpu, APickFindsTheValue) {
  show(sampled_volume({60, 60, 60}, {1, 1, 1}, waves));
  add(0, 900, 1100);
  add(2, 0, 700);
  const Plane plane{{0.6, 0.8, 0}, 40};
  settings_.slices = {plane};
  draw("pick");
  const auto found = pixels();
  int values = 0, differing = 0;
  for (int y = 5; y < kSize; y += 12) {
    for (int x = 5; x < kSize; x += 12) {
      const auto pick = renderer_->pick(x + 0.5, kSize - y - 0.5, kSize, kSize).value();
      const auto& pixel = found[size_t(y) * kSize + size_t(x)];
      const bool shows_value = pixel.hit && pixel.slice == Slice::values;
      differing += shows_value != (pick && pick->slice);
      if (!pick || !shows_value) continue;
      ++values;
      EXPECT_LT(length(pick->position - on_plane(x, y, plane)), 1e-6);
      EXPECT_NEAR(pick->value, double(pixel.scalar) * 2000, 1.5);
    }
  }
  EXPECT_GT(values, 50);
  EXPECT_LE(differing, 2);
}

TEST_F(SlicesGpu, APickFindsASliceInAFaceOfTheClipping) {
  TestVolume volume = sampled_volume({60, 60, 60}, {0.4, 0.4, 0.6}, waves);
  volume.grid.origin = {-51.2, 3.7, 11.1};
  show(volume);
  add(0, 0, 2000);
  std::vector<ChunkHandle> handles(next_handle_ - 1);
  std::iota(handles.begin(), handles.end(), ChunkHandle{1});
  renderer_->set_visible(handles);
  settings_.isosurfaces = {{1000, {0.85f, 0.8f, 0.7f}, 1}};
  settings_.clip_box_low = {0, 1 / 3.0, 0};
  settings_.slices = {{{0, 3, 0}, 3 * (3.7 + 0.4 * 59 / 3.0)}};
  for (const bool caps : {false, true}) {
    settings_.clip_caps = caps;
    draw("pick-in-face");
    const auto found = pixels();
    int values = 0;
    for (int y = 5; y < kSize; y += 12) {
      for (int x = 5; x < kSize; x += 12) {
        const auto& pixel = found[size_t(y) * kSize + size_t(x)];
        if (!pixel.hit || pixel.slice != Slice::values) continue;
        ++values;
        const auto pick = renderer_->pick(x + 0.5, kSize - y - 0.5, kSize, kSize).value();
        ASSERT_TRUE(pick && pick->slice) << x << ' ' << y << ' ' << caps;
        EXPECT_NEAR(length(pick->normal), 1, 1e-9);
      }
    }
    EXPECT_GT(values, 50);
  }
}

TEST_F(SlicesGpu, SurfacesJustInFrontHideThemAlsoFromWithinTheVolume) {
  show(ball());
  add(0, 0, 2000);
  const ChunkHandle handle = next_handle_ - 1;
  renderer_->set_visible({&handle, 1});
  settings_.kind = SplatKind::exact;
  settings_.isosurfaces = {{1400, {0.85f, 0.8f, 0.7f}, 1}};
  camera_.azimuth = camera_.elevation = 0;  // looks along +y, from within the ball
  camera_.distance = 10;
  draw("within");
  const size_t middle = size_t(kSize / 2) * kSize + kSize / 2;
  const CameraFrame frame = camera_frame(camera_);
  const double surface = frame.eye.y + double(pixels()[middle].depth);
  EXPECT_NEAR(surface, 39, 0.1);
  for (const double away : {-0.04, 0.04}) {
    settings_.slices = {{{0, 1, 0}, surface + away}};
    draw("near-surface");
    EXPECT_EQ(pixels()[middle].slice, away < 0 ? Slice::values : Slice::none) << away;
  }
}

TEST_F(SlicesGpu, NewChunksAndPlanesChangeThePicture) {
  show(ball());
  settings_.slices = {{{0, 1, 0}, 24}};
  draw("empty");
  EXPECT_EQ(count(Slice::values), 0);
  EXPECT_FALSE(renderer_->needs_redraw(kSize, kSize));
  add(0, 0, 2000);
  EXPECT_TRUE(renderer_->needs_redraw(kSize, kSize));
  draw("arrived");
  EXPECT_GT(count(Slice::values), 1000);
  renderer_->remove_chunk(next_handle_ - 1);
  EXPECT_TRUE(renderer_->needs_redraw(kSize, kSize));
  draw("removed");
  EXPECT_EQ(count(Slice::values), 0);
  // Invalid planes are ignored, and so are planes beyond the maximum number.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Plane& plane :
       {Plane{{0, 0, 0}, 1}, Plane{{nan, 0, 1}, 1}, Plane{{0, infinity, 0}, 1},
        Plane{{0, 1, 0}, nan}, Plane{{0, 1, 0}, infinity}, Plane{{0, 1, 0}, 1e300}}) {
    settings_.slices.assign(7, plane);
    draw("none");
    EXPECT_EQ(count(Slice::no_data), 0);
  }
  // Normals of any length.
  for (const double size : {1e-200, 1e200}) {
    settings_.slices = {{{0, size, 0}, 24 * size}};
    draw("length");
    EXPECT_GT(count(Slice::no_data), 100) << size;
  }
}

}  // namespace
}  // namespace isosplat::render
