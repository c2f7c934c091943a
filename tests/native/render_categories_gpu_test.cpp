// Surfaces coloured by a field of labels, compared pixel by pixel with the label of the voxel that
// is nearest to the pixel's position.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/native/field_renderer_test.h"

namespace isosplat::render {
namespace {

/// Labels 1 to 4 in boxes of 5 voxels, which meet everywhere. None in a part, if `has_missing`.
TestVolume parcels(bool has_missing = false) {
  TestVolume volume = pressures();
  for (int32_t z = 0; z < 49; ++z) {
    for (int32_t y = 0; y < 49; ++y) {
      for (int32_t x = 0; x < 49; ++x) {
        const int label = 1 + (x / 5 + 2 * (y / 5) + 3 * (z / 5)) % 4;
        const bool is_missing = has_missing && z > 30;
        volume.quantized_values[static_cast<size_t>((z * 49 + y) * 49 + x)] =
            is_missing ? kMissingVoxel : static_cast<QuantizedValue>(1000 * label);
      }
    }
  }
  return volume;
}

/// The coarser level of labels: the voxels at its positions.
TestVolume picked(const TestVolume& finer) {
  TestVolume coarse = coarser_volume(finer);
  const Index3 n = coarse.grid.voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        coarse.quantized_values[static_cast<size_t>((z * n.y + y) * n.x + x)] =
            finer.at(2 * x, 2 * y, 2 * z);
      }
    }
  }
  return coarse;
}

class CategoriesGpu : public FieldRendererTest {
 protected:
  void prepare() override {
    FieldRendererTest::prepare();
    // Values −500 + label; colours begin at −500.
    mapping_.offset = -500;
    mapping_.scale = 0.001;
    settings_.field_first_category = -500;
    settings_.field_categories = {
        {0, 0, 0}, {220, 20, 20}, {20, 200, 20}, {30, 30, 230}, {220, 220, 20}};
  }

  void show_labels(uint32_t level, bool has_missing = false) {
    mapping_.has_missing = has_missing;
    TestVolume labels = parcels(has_missing);
    show(ball(), labels, level, /*values=*/false);
    for (uint32_t i = 0; i < level; ++i) labels = picked(labels);
    field_ = labels;
    ASSERT_TRUE(renderer_->set_field(mapping_));
    ASSERT_TRUE(renderer_->set_chunk_field(kHandle, values_for(field_, samples_)));
  }

  /// The labels of the voxels that are at most `rounding` voxels farther from a position than the
  /// nearest one. 0: missing.
  std::set<int> labels_at(Vec3d voxel, double rounding) const {
    const double scale = std::ldexp(1.0, -static_cast<int>(level_));
    const double p[3] = {voxel.x * scale, voxel.y * scale, voxel.z * scale};
    const double far = rounding * scale;
    const Index3 n = field_.grid.voxels;
    const int32_t last[3] = {n.x - 1, n.y - 1, n.z - 1};
    std::set<int32_t> at[3];
    for (int axis = 0; axis < 3; ++axis) {
      for (const double moved : {-far, far}) {
        const auto nearest = static_cast<int32_t>(std::floor(p[axis] + moved + 0.5));
        at[axis].insert(std::clamp(nearest, 0, last[axis]));
      }
    }
    std::set<int> labels;
    for (const int32_t x : at[0]) {
      for (const int32_t y : at[1]) {
        for (const int32_t z : at[2]) {
          const QuantizedValue value = field_.at(x, y, z);
          labels.insert(value == kMissingVoxel ? 0 : value / 1000);
        }
      }
    }
    return labels;
  }

  struct Labels {
    int right = 0, wrong = 0, missing = 0;
    std::set<int> found;
  };

  Labels compare_labels(double rounding) {
    Labels labels;
    const auto all = pixels();
    for (size_t i = 0; i < all.size(); ++i) {
      if (!all[i].hit) continue;
      EXPECT_NE(all[i].field, Field::none);
      const int shown = all[i].field == Field::value ? static_cast<int>(all[i].scalar) : 0;
      const auto expected = labels_at(voxel_at(i, double(all[i].depth)), rounding);
      ++(expected.contains(shown) ? labels.right : labels.wrong);
      labels.missing += shown == 0;
      labels.found.insert(shown);
    }
    return labels;
  }
};

TEST_F(CategoriesGpu, EachPixelShowsTheLabelOfTheNearestVoxel) {
  for (const uint32_t level : {0u, 1u}) {
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
      settings_.kind = kind;
      show_labels(level);
      draw("labels");
      // Ellipses reach beyond their cells by 0.01 cells.
      const Labels labels = compare_labels(0.03 * (level ? 2 : 1));
      EXPECT_GT(labels.right, 9000);
      EXPECT_EQ(labels.wrong, 0) << "level " << level << ", kind " << int(kind);
      EXPECT_EQ(labels.found, (std::set<int>{1, 2, 3, 4}));
    }
  }
}

TEST_F(CategoriesGpu, SoDoTrianglesAndLargeSplats) {
  settings_.kind = SplatKind::quad;
  show_labels(0);
  camera_.distance *= 0.4;
  draw("label-triangles");
  Labels labels = compare_labels(0.03);
  EXPECT_GT(labels.right, 30000);
  EXPECT_EQ(labels.wrong, 0);
  renderer_ = std::move(*Renderer::create(/*max_point_size=*/4));
  for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    show_labels(0);
    draw("pulled-labels");
    labels = compare_labels(0.03);
    EXPECT_GT(labels.right, 9000);
    EXPECT_EQ(labels.wrong, 0);
  }
}

TEST_F(CategoriesGpu, ASquareShowsTheLabelAtItsSample) {
  settings_.kind = SplatKind::quad;
  for (const uint32_t level : {0u, 1u}) {
    show_labels(level);
    camera_.distance *= 2;
    draw("label-squares");
    const Labels labels = compare_labels(1.0 * (level ? 2 : 1));
    EXPECT_GT(labels.right, 2500);
    EXPECT_EQ(labels.wrong, 0);
    EXPECT_EQ(labels.found, (std::set<int>{1, 2, 3, 4}));
  }
}

TEST_F(CategoriesGpu, VoxelsWithoutALabelAreMissingByThemselves) {
  settings_.kind = SplatKind::exact;
  show_labels(0, true);
  draw("missing-labels");
  const Labels labels = compare_labels(0.03);
  EXPECT_EQ(labels.wrong, 0);
  EXPECT_GT(labels.missing, 1000);
  EXPECT_LT(labels.missing, labels.right - 1000);
}

TEST_F(CategoriesGpu, ValuesWithoutAColourAreMissing) {
  settings_.kind = SplatKind::exact;
  settings_.field_first_category = -498;  // colours of the labels 2 and 3
  settings_.field_categories.resize(2);
  show_labels(0);
  draw("few-labels");
  std::set<int> found;
  for (const SurfacePixel& pixel : pixels()) {
    if (pixel.hit) found.insert(pixel.field == Field::value ? static_cast<int>(pixel.scalar) : -1);
  }
  EXPECT_EQ(found, (std::set<int>{-1, 0, 1}));
}

/// Which of the four colours a pixel of the image has, lit: by its largest channels.
int colour_of(const uint8_t* rgba) {
  const int r = rgba[0], g = rgba[1], b = rgba[2];
  if (b > r && b > g) return 3;
  if (g > 2 * r) return 2;
  return r > 2 * g ? 1 : 4;
}

TEST_F(CategoriesGpu, EachLabelHasItsOwnColour) {
  settings_.colour_map = ColourMap::turbo;
  settings_.light.highlight = 0;
  for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse, SplatKind::quad}) {
    settings_.kind = kind;
    show_labels(0);
    const Image image = draw("label-colours");
    const auto all = pixels();
    int right = 0, wrong = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      if (!all[i].hit) continue;
      const size_t row = kSize - 1 - i / kSize;
      const uint8_t* rgba = &image.rgba[4 * (row * kSize + i % kSize)];
      ++(colour_of(rgba) == static_cast<int>(all[i].scalar) ? right : wrong);
    }
    EXPECT_GT(right, 9000) << int(kind);
    EXPECT_LT(wrong, right / 200) << int(kind);  // dark pixels at the silhouette
  }
}

TEST_F(CategoriesGpu, APickHasTheLabelOfTheNearestVoxel) {
  settings_.kind = SplatKind::exact;
  show_labels(0);
  draw("picked-labels");
  int picked = 0;
  for (int y = 40; y < kSize; y += 15) {
    for (int x = 40; x < kSize; x += 15) {
      const auto pick = renderer_->pick(x + 0.5, y + 0.5, kSize, kSize);
      ASSERT_TRUE(pick);
      if (!*pick) continue;
      ASSERT_TRUE((*pick)->field.has_value());
      const auto expected = labels_at((*pick)->voxel, 1e-3);
      EXPECT_TRUE(expected.contains(static_cast<int>(std::lround(*(*pick)->field + 500))))
          << *(*pick)->field;
      ++picked;
    }
  }
  EXPECT_GT(picked, 40);
}

}  // namespace
}  // namespace isosplat::render
