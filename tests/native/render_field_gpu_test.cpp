// Surfaces coloured by a second field, compared pixel by pixel with the field's trilinear function
// at the pixel's position on the surface.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "shared/render/settings/colour_maps.h"
#include "tests/native/field_renderer_test.h"

namespace isosplat::render {
namespace {

using FieldGpu = FieldRendererTest;

/// The largest change of the field along a voxel, in quantized values: the gradient of pressure().
constexpr double kSteepest = 2500;
/// The error of a position from the depth of a pixel, in voxels: 24 bits of depth, and single
/// precision.
constexpr double kPositionError = 0.004;
/// Half of a step of the 65533 positions in the colour map, in quantized values.
constexpr double kStep = 0.5 * 24000 / 65533;

TEST_F(FieldGpu, EachPixelShowsTheValueAtItsPositionOnTheSurface) {
  for (const uint32_t level : {0u, 1u}) {
    for (const bool orthographic : {false, true}) {
      show(ball(), pressures(), level);
      camera_ = default_camera(volume_.grid, 1, orthographic);
      camera_.azimuth = 25;
      for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
        for (const Shading shading : {Shading::smooth, Shading::exact}) {
          settings_.kind = kind;
          settings_.shading = shading;
          draw("splats");
          const Comparison c = compare();
          EXPECT_GT(c.values, 9000);
          EXPECT_EQ(c.missing + c.none, 0);
          // Ellipses reach beyond their cells by 0.01 cells, and there the gradient may differ by
          // three tenths of the largest one, per voxel of a cell's side.
          const double beyond = kind == SplatKind::ellipse ? 0.01 * 0.3 * (level ? 4 : 1) : 0;
          EXPECT_LT(c.most, kStep + kSteepest * (kPositionError + beyond))
              << "level " << level << ", kind " << int(kind);
        }
      }
    }
  }
}

TEST_F(FieldGpu, SquaresShowTheValueAtTheirSample) {
  settings_.kind = SplatKind::quad;
  for (const uint32_t level : {0u, 1u}) {
    show(ball(), pressures(), level);
    camera_.distance *= 2;  // so that coarse squares are not ray cast
    draw("squares");
    const Comparison c = compare();
    EXPECT_GT(c.values, 2500);
    EXPECT_EQ(c.missing + c.none, 0);
    // A pixel of a square is at most a cell's diagonal from the sample.
    EXPECT_LT(c.most, kSteepest * std::sqrt(3) * std::ldexp(1.0, int(level)));
    // Each square has one value: there are at most as many as cells.
    std::vector<float> shown;
    for (const SurfacePixel& pixel : pixels()) {
      if (pixel.hit) shown.push_back(pixel.scalar);
    }
    std::sort(shown.begin(), shown.end());
    shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
    EXPECT_GT(shown.size(), 200u);
    EXPECT_LE(shown.size(), samples_.size());
  }
}

TEST_F(FieldGpu, CloseUpTrianglesShowTheValueAtEachPixel) {
  settings_.kind = SplatKind::quad;
  for (const Shading shading : {Shading::smooth, Shading::exact}) {
    settings_.shading = shading;
    show(ball(), pressures());
    camera_.distance *= 0.4;
    draw("triangles");
    const Comparison c = compare();
    EXPECT_GT(c.values, 30000);
    EXPECT_LT(c.most, kStep + kSteepest * kPositionError);
  }
}

TEST_F(FieldGpu, SplatsThatAreTooLargeForPointsShowIt) {
  renderer_ = std::move(*Renderer::create(/*max_point_size=*/4));
  for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    show(ball(), pressures());
    draw("pulled");
    const Comparison c = compare();
    EXPECT_GT(c.values, 9000);
    EXPECT_LT(c.most, kStep + kSteepest * kPositionError);
  }
}

TEST_F(FieldGpu, AShearedGridAndClippingKeepIt) {
  VolumeGrid grid{{49, 49, 49}, {1, 1.25, 0.8}};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0, 0, 0, 1};
  TestVolume volume = ball(), field = pressures();
  volume.grid = field.grid = grid;
  show(volume, field);
  settings_.clip_box_high.x = 0.6;
  settings_.clip_caps = true;
  draw("sheared");
  const auto all = pixels();
  EXPECT_GT(std::count_if(all.begin(), all.end(), [](const auto& p) { return p.cap; }), 1000);
  const Comparison c = compare();
  EXPECT_GT(c.values, 5000);
  EXPECT_LT(c.most, kStep + kSteepest * 2 * kPositionError);
}

TEST_F(FieldGpu, MissingValuesHaveAColourOfTheirOwn) {
  mapping_.has_missing = true;
  TestVolume field = pressures();
  // The half with x < 24 has no values.
  for (size_t i = 0; i < field.quantized_values.size(); ++i) {
    if (i % 49 < 24) field.quantized_values[i] = kMissingVoxel;
  }
  settings_.field_missing_colour = {1, 0, 1};
  settings_.light = {};
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    for (const double distance : {1.0, 0.4}) {
      settings_.kind = kind;
      show(ball(), field);
      camera_.azimuth = 10;
      camera_.distance *= distance;
      const Image image = draw("missing");
      const auto all = pixels();
      int missing = 0, values = 0, wrong = 0, magenta = 0;
      for (size_t i = 0; i < all.size(); ++i) {
        if (!all[i].hit) continue;
        const double x = voxel_at(i, double(all[i].depth)).x;
        const bool is_missing = all[i].field == Field::missing;
        missing += is_missing;
        values += all[i].field == Field::value;
        // Cells with a missing corner: those below 24. Squares reach beyond their cells.
        const double margin = kind == SplatKind::quad ? 2 : 0.02;
        if (std::abs(x - 24) > margin) wrong += is_missing != (x < 24);
        const size_t row = size_t(kSize) - 1 - i / kSize;
        const uint8_t* rgba = &image.rgba[4 * (row * kSize + i % kSize)];
        magenta += is_missing && rgba[0] > 100 && rgba[1] < 10 && rgba[2] == rgba[0];
      }
      EXPECT_GT(missing, 4000);
      EXPECT_GT(values, 5000);
      EXPECT_EQ(wrong, 0) << int(kind);
      EXPECT_GT(magenta, 0.98 * missing) << int(kind);
    }
  }
  // Without missing values, 65535 is a number.
  mapping_.has_missing = false;
  show(ball(), field);
  draw("largest");
  EXPECT_EQ(compare().missing, 0);
}

TEST_F(FieldGpu, ColoursAreThoseOfTheMap) {
  show(ball(), pressures());
  settings_.kind = SplatKind::exact;
  // Hue and saturation are those of the legend: the light only scales the linear colour.
  const auto linear = [](double level) {
    level /= 255;
    return level <= 0.04045 ? level / 12.92 : std::pow((level + 0.055) / 1.055, 2.4);
  };
  const auto check = [&](auto place) {
    const Image image = draw("colours");
    const auto all = pixels();
    int compared = 0, differing = 0;
    for (size_t i = 0; i < all.size(); i += 3) {
      if (!all[i].hit || all[i].field != Field::value) continue;
      const double value = mapping_.value(field_at(voxel_at(i, double(all[i].depth))));
      const double at = std::clamp(double(place(value)), 0.0, 1.0);
      const auto& c = kColourMapTable[0][static_cast<size_t>(std::lround(255 * at))];
      const size_t row = size_t(kSize) - 1 - i / kSize;
      const uint8_t* rgba = &image.rgba[4 * (row * kSize + i % kSize)];
      // The factor of the largest channel applies to all.
      const size_t most =
          size_t(std::max_element(std::begin(c), std::begin(c) + 3) - std::begin(c));
      const double light = linear(rgba[most]) / linear(c[most]);
      ++compared;
      for (size_t channel = 0; channel < 3; ++channel) {
        const double expected = light * linear(c[channel]);
        differing += std::abs(linear(rgba[channel]) - expected) > 0.025;
      }
      EXPECT_LT(light, 1.05);
      EXPECT_GT(light, 0.35);
    }
    EXPECT_GT(compared, 4000);
    EXPECT_LT(differing, 0.01 * compared);
  };
  const double low = settings_.colour_low, high = settings_.colour_high;
  check([&](double value) { return (value - low) / (high - low); });
  settings_.field_scale = FieldScale::symmetric;
  const double most = std::max(std::abs(low), std::abs(high));
  check([&](double value) { return 0.5 + 0.5 * value / most; });
  settings_.field_scale = FieldScale::logarithmic;
  settings_.colour_low = 10;
  settings_.colour_high = 150;
  check(
      [&](double value) { return value > 0 ? std::log(value / 10) / std::log(150.0 / 10) : 0.0; });
  settings_.field_scale = FieldScale::linear;
  settings_.field_steps = 5;
  check([&](double value) {
    return std::min(std::floor(std::clamp((value - 10) / 140, 0.0, 1.0) * 5), 4.0) / 4;
  });
}

TEST_F(FieldGpu, LimitsOfALogarithmicScaleAreAboveZero) {
  RenderSettings settings;
  settings.field_scale = FieldScale::logarithmic;
  settings.colour_low = -4;
  settings.colour_high = 500;
  EXPECT_EQ(field_range(settings).low, 0.5);
  EXPECT_EQ(field_range(settings).high, 500);
  settings.colour_high = 0;
  EXPECT_EQ(field_range(settings).low, 0.001);
  EXPECT_EQ(field_range(settings).high, 1);
}

TEST_F(FieldGpu, ChunksWithoutValuesHaveTheColourOfTheirIsosurface) {
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    show(ball(), pressures(), 0, /*values=*/false);
    settings_.colour_by = ColourBy::isovalue;  // any that is lit as values are
    settings_.colour_by = ColourBy::field;
    const Image without_field = draw("no-field");
    ASSERT_TRUE(renderer_->set_field(mapping_));
    const Image waiting = draw("waiting");
    EXPECT_EQ(waiting.rgba, without_field.rgba) << int(kind);
    EXPECT_GT(compare().none, 9000);
    ASSERT_TRUE(renderer_->set_chunk_field(kHandle, values_for(field_, samples_)));
    EXPECT_TRUE(renderer_->needs_redraw(kSize, kSize));
    EXPECT_NE(draw("arrived").rgba, waiting.rgba);
    EXPECT_EQ(compare().none, 0);
    // Another field: the values of the first one are gone.
    ValueMapping other = mapping_;
    other.scale = 2;
    ASSERT_TRUE(renderer_->set_field(other));
    EXPECT_EQ(draw("other").rgba, waiting.rgba) << int(kind);
    EXPECT_GT(compare().none, 9000);
    ASSERT_TRUE(renderer_->set_field(std::nullopt));
    EXPECT_EQ(draw("removed").rgba, waiting.rgba) << int(kind);
  }
}

TEST_F(FieldGpu, PicturesThatDoNotShowItStayTheSame) {
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    for (const ColourBy by : {ColourBy::isosurface, ColourBy::gradient, ColourBy::depth}) {
      settings_.colour_by = by;
      show(ball(), pressures(), 0, /*values=*/false);
      const Image before = draw("without");
      show(ball(), pressures());
      EXPECT_EQ(draw("with").rgba, before.rgba) << int(kind) << ' ' << int(by);
    }
  }
}

TEST_F(FieldGpu, AVolumeWithoutAFieldIsDrawnBesideOneWithIt) {
  TestVolume beside = ball();
  beside.grid.origin.x += 60;
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse}) {
    settings_.kind = kind;
    settings_.isosurfaces = {{kIsovalue, {0.1f, 0.8f, 0.2f}, 1, 0},
                             {kIsovalue, {0.1f, 0.2f, 0.9f}, 0.5f, 1}};
    show(beside, pressures(), 0, /*values=*/false, 1);
    show(ball(), pressures());
    camera_ = default_camera(renderer_->scene_grid());
    camera_.azimuth = 20;
    draw("beside-still", /*still=*/true);
    draw("beside");
    // Of the opaque layer, which has the first volume alone.
    const Comparison c = compare();
    EXPECT_GT(c.values, 3000);
    EXPECT_EQ(c.none, 0);
    if (kind == SplatKind::ellipse) {
      EXPECT_LT(c.most, kStep + kSteepest * 3 * kPositionError);
    }
    settings_.isosurfaces[1].opacity = 1;
    draw("beside-opaque");
    int values = 0, none = 0, wrong = 0;
    for (const SurfacePixel& pixel : pixels()) {
      if (!pixel.hit) continue;
      values += pixel.field == Field::value;
      none += pixel.field == Field::none;
      wrong += (pixel.isosurface == 0) != (pixel.field == Field::value);
    }
    EXPECT_GT(values, 3000);
    EXPECT_GT(none, 3000);
    EXPECT_EQ(wrong, 0);
    renderer_->remove_volume(1);
  }
}

TEST_F(FieldGpu, TranslucentSurfacesAndTilesShowIt) {
  show(ball(), pressures());
  settings_.isosurfaces[0].opacity = 0.6f;
  settings_.background = {1, 1, 1, 1};
  const Image mapped = draw("translucent");
  settings_.colour_by = ColourBy::isosurface;
  EXPECT_NE(draw("translucent-plain").rgba, mapped.rgba);
  settings_.colour_by = ColourBy::field;
  settings_.isosurfaces[0].opacity = 1;
  const Image whole = draw("whole", /*still=*/true);
  ASSERT_TRUE(renderer_->begin_tiles(kSize, kSize));
  constexpr int kTile = kSize / 2;
  std::vector<uint8_t> tile(4 * kTile * kTile);
  int differing = 0;
  for (int part = 0; part < 4; ++part) {
    const int left = part % 2 * kTile, top = part / 2 * kTile;
    ASSERT_TRUE(renderer_->draw_tile(left, top, kTile, kTile, kStillPictures, tile));
    for (int i = 0; i < kTile * kTile; ++i) {
      const size_t at = 4 * (size_t(top + i / kTile) * kSize + size_t(left + i % kTile));
      int most = 0;
      for (size_t k = 0; k < 4; ++k) {
        most = std::max(most, std::abs(int(whole.rgba[at + k]) - int(tile[4 * size_t(i) + k])));
      }
      differing += most > 3;
    }
  }
  renderer_->end_tiles();
  EXPECT_LT(differing, kSize * kSize / 200);
}

TEST_F(FieldGpu, LitSquaresHaveTheColoursOfSurfacePixels) {
  // The picture of draw() is lit while squares are drawn; that of tiles is composed of layers.
  settings_.kind = SplatKind::quad;
  settings_.field_steps = 7;
  for (const double distance : {1.0, 0.4}) {
    show(ball(), pressures());
    camera_.distance *= distance;
    const Image lit = draw("lit");
    settings_.isosurfaces.push_back({1e9, {1, 1, 1}, 0.5f});  // translucent, and not in the picture
    const Image composed = draw("composed");
    settings_.isosurfaces.pop_back();
    int differing = 0, hit = 0;
    for (size_t i = 0; i < lit.rgba.size(); i += 4) {
      int most = 0;
      for (size_t k = 0; k < 3; ++k) {
        most = std::max(most, std::abs(int(lit.rgba[i + k]) - int(composed.rgba[i + k])));
      }
      hit += lit.rgba[i] < 250;
      differing += most > 4;
    }
    EXPECT_GT(hit, 9000);
    EXPECT_LT(differing, 0.01 * hit);
  }
}

TEST_F(FieldGpu, APickFindsTheValue) {
  mapping_.has_missing = true;
  TestVolume field = pressures();
  for (size_t i = 0; i < field.quantized_values.size(); ++i) {
    if (i % 49 < 20) field.quantized_values[i] = kMissingVoxel;
  }
  show(ball(), pressures(), 0, /*values=*/false);
  settings_.colour_by = ColourBy::isosurface;  // picks find it in any colours
  draw("pick");
  const double middle = 0.5 * kSize;
  EXPECT_FALSE(renderer_->pick(middle, middle, kSize, kSize).value()->field);
  for (const uint32_t level : {0u, 1u}) {
    show(ball(), level == 0 ? field : pressures(), level);
    draw("pick");
    int values = 0, missing = 0;
    for (int y = 5; y < kSize; y += 9) {
      for (int x = 5; x < kSize; x += 9) {
        const auto pick = renderer_->pick(x + 0.5, y + 0.5, kSize, kSize).value();
        if (!pick) continue;
        ASSERT_TRUE(pick->field) << x << ' ' << y;
        if (std::isnan(*pick->field)) {
          ++missing;
          EXPECT_LT(pick->voxel.x, 20.001);
          continue;
        }
        ++values;
        EXPECT_NEAR(*pick->field, mapping_.value(field_at(pick->voxel)), 0.02);
      }
    }
    EXPECT_GT(values, 60);
    EXPECT_EQ(missing > 20, level == 0);
  }
}

TEST_F(FieldGpu, WrongCallsAreRefusedAndMemoryIsFreed) {
  EXPECT_EQ(renderer_->set_field(mapping_, 3).error().status, Status::invalid_argument);
  show(ball(), pressures(), 0, /*values=*/false);
  draw("before");
  const auto values = values_for(field_, samples_);
  EXPECT_EQ(renderer_->set_chunk_field(kHandle, values).error().status, Status::invalid_argument);
  ASSERT_TRUE(renderer_->set_field(mapping_));
  const auto bytes = [&] {
    FrameStatistics statistics;
    EXPECT_TRUE(draw_image(*renderer_, kSize, kSize, &statistics, /*smooth=*/false));
    return statistics.gpu_bytes;
  };
  const uint64_t before = bytes();
  EXPECT_EQ(renderer_->set_chunk_field(kHandle + 1, values).error().status,
            Status::invalid_argument);
  const auto short_ = std::span(values).first(values.size() - 1);
  const auto refused = renderer_->set_chunk_field(kHandle, short_);
  EXPECT_EQ(refused.error().status, Status::invalid_argument);
  EXPECT_NE(refused.error().message.find(std::to_string(values.size())), std::string::npos);
  EXPECT_EQ(bytes(), before);
  ASSERT_TRUE(renderer_->set_chunk_field(kHandle, values));
  ASSERT_TRUE(renderer_->set_chunk_field(kHandle, values));  // again
  EXPECT_EQ(bytes(), before + (uint64_t{16} << 19));
  ASSERT_TRUE(renderer_->check_gpu());
  ASSERT_TRUE(renderer_->set_field(std::nullopt));
  EXPECT_EQ(bytes(), before);
  // A chunk that is added again has no values, and they are freed with it.
  ASSERT_TRUE(renderer_->set_field(mapping_));
  ASSERT_TRUE(renderer_->set_chunk_field(kHandle, values));
  ASSERT_TRUE(renderer_->add_chunk(kHandle, {0, {0, 0, 0}}, samples_));
  EXPECT_EQ(bytes(), before);
  draw("again");
  EXPECT_GT(compare().none, 9000);
  ASSERT_TRUE(renderer_->check_gpu());
  // Samples can be read back, for the decoder of field chunks.
  const auto range = renderer_->bind_samples(kHandle);
  ASSERT_TRUE(range);
  ASSERT_EQ(range->count, samples_.size());
  const void* mapped = glMapBufferRange(
      GL_ARRAY_BUFFER, static_cast<GLintptr>(range->offset_bytes()),
      static_cast<GLsizeiptr>(range->count * sizeof(PackedSample)), GL_MAP_READ_BIT);
  ASSERT_TRUE(mapped);
  std::vector<PackedSample> ordered;
  cluster_samples(samples_, ordered);
  EXPECT_EQ(std::memcmp(mapped, ordered.data(), ordered.size() * sizeof(PackedSample)), 0);
  glUnmapBuffer(GL_ARRAY_BUFFER);
  EXPECT_EQ(renderer_->bind_samples(99).error().status, Status::invalid_argument);
  // An empty chunk.
  ASSERT_TRUE(renderer_->add_chunk(kHandle + 1, {0, {0, 0, 0}}, {}));
  ASSERT_TRUE(renderer_->set_chunk_field(kHandle + 1, {}));
  ASSERT_TRUE(renderer_->check_gpu());
}

}  // namespace
}  // namespace isosplat::render
