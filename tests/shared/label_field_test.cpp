#include "shared/core/preprocess/label_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isosplat {
namespace {

constexpr int kMargin = 2;

/// A volume of labels in a margin of background, so that a box over all of it holds every label.
struct TestLabels {
  std::uint32_t size;
  std::vector<std::uint16_t> labels;

  explicit TestLabels(std::uint32_t edge) : size(edge), labels(std::size_t{edge} * edge * edge) {}

  std::size_t at(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{z} * size + y) * size + x;
  }

  std::vector<std::uint8_t> field(std::uint16_t label) const {
    const auto edge = static_cast<std::int32_t>(size);
    return label_field({labels, {edge, edge, edge}}, label, {{0, 0, 0}, {edge, edge, edge}});
  }

  void add_ellipsoid(std::uint16_t label, Vec3<double> centre, Vec3<double> radii) {
    for (std::uint32_t z = 0; z < size; ++z)
      for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x) {
          const double u = (x - centre.x) / radii.x;
          const double v = (y - centre.y) / radii.y;
          const double w = (z - centre.z) / radii.z;
          if (u * u + v * v + w * w <= 1) labels[at(x, y, z)] = label;
        }
  }

  double count(std::uint16_t label) const {
    double voxels = 0;
    for (const std::uint16_t here : labels) voxels += here == label ? 1 : 0;
    return voxels;
  }
};

/// The volume above the isovalue of the trilinear field, from 6³ points a cell.
double enclosed_volume(const TestLabels& volume, const std::vector<std::uint8_t>& field) {
  constexpr int kPoints = 6;
  double inside = 0;
  for (std::uint32_t z = 0; z + 1 < volume.size; ++z)
    for (std::uint32_t y = 0; y + 1 < volume.size; ++y)
      for (std::uint32_t x = 0; x + 1 < volume.size; ++x)
        for (int point = 0; point < kPoints * kPoints * kPoints; ++point) {
          const double u = (point % kPoints + 0.5) / kPoints;
          const double v = (point / kPoints % kPoints + 0.5) / kPoints;
          const double w = (point / kPoints / kPoints + 0.5) / kPoints;
          double value = 0;
          for (std::uint32_t corner = 0; corner < 8; ++corner) {
            const std::uint32_t i = corner & 1U;
            const std::uint32_t j = corner >> 1U & 1U;
            const std::uint32_t k = corner >> 2U;
            value += (i != 0 ? u : 1 - u) * (j != 0 ? v : 1 - v) * (k != 0 ? w : 1 - w) *
                     field[volume.at(x + i, y + j, z + k)];
          }
          inside += value > kLabelFieldIsovalue ? 1 : 0;
        }
  return inside / (kPoints * kPoints * kPoints);
}

void expect_sides(const TestLabels& volume, std::uint16_t label) {
  const std::vector<std::uint8_t> field = volume.field(label);
  for (std::size_t i = 0; i < field.size(); ++i) {
    ASSERT_EQ(field[i] > kLabelFieldIsovalue, volume.labels[i] == label)
        << "label " << label << ", voxel " << i;
    ASSERT_NE(field[i], kLabelFieldIsovalue);
  }
}

TEST(LabelField, SeparatesTheVoxelsOfALabelInRandomVolumes) {
  std::mt19937 random(7);
  for (int volume_number = 0; volume_number < 20; ++volume_number) {
    TestLabels volume(12);
    for (std::uint16_t& label : volume.labels)
      label = static_cast<std::uint16_t>(random() % 4 * 21845);
    for (const int label : {0, 21845, 43690, 65535})
      expect_sides(volume, static_cast<std::uint16_t>(label));
  }
}

TEST(LabelField, KeepsSheetsRodsAndVoxelsOfOneVoxel) {
  TestLabels volume(16);
  for (std::uint32_t a = 2; a < 14; ++a) {
    for (std::uint32_t b = 2; b < 14; ++b) volume.labels[volume.at(4, a, b)] = 1;
    volume.labels[volume.at(8, 8, a)] = 2;
  }
  volume.labels[volume.at(12, 12, 12)] = 3;
  for (const std::uint16_t label : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}})
    expect_sides(volume, label);
}

TEST(LabelField, ClosesALabelAtTheBorderOfTheVolume) {
  const std::vector<std::uint16_t> labels(27, 5);
  constexpr int kEdge = 3 + 2 * kMargin;
  constexpr int kFirst = -kMargin;
  const std::vector<std::uint8_t> field =
      label_field({labels, {3, 3, 3}}, 5, {{kFirst, kFirst, kFirst}, {kEdge, kEdge, kEdge}});
  for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
    bool inside = true;
    for (const int index : {i % kEdge, i / kEdge % kEdge, i / kEdge / kEdge})
      inside = inside && index >= kMargin && index < kMargin + 3;
    EXPECT_EQ(field[static_cast<std::size_t>(i)] > kLabelFieldIsovalue, inside);
  }
}

TEST(LabelField, TwoNeighboursShareTheirBorder) {
  TestLabels volume(24);
  volume.add_ellipsoid(1, {12, 11, 12.5}, {8, 6, 7});
  const std::vector<std::uint8_t> label = volume.field(1);
  const std::vector<std::uint8_t> background = volume.field(0);
  for (std::uint32_t z = kMargin; z < 24U - kMargin; ++z)
    for (std::uint32_t y = kMargin; y < 24U - kMargin; ++y)
      for (std::uint32_t x = kMargin; x < 24U - kMargin; ++x) {
        const std::size_t i = volume.at(x, y, z);
        ASSERT_EQ(label[i] + background[i], 2 * kLabelFieldIsovalue);
      }
}

TEST(LabelField, VolumesOfSurfacesAgreeWithVoxelCounts) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> radius(6.3, 11);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (int number = 0; number < 8; ++number) {
    TestLabels volume(32);
    const Vec3<double> centre{16 + shift(random), 16 + shift(random), 16 + shift(random)};
    volume.add_ellipsoid(1, centre, {radius(random), radius(random), radius(random)});
    const double voxels = volume.count(1);
    ASSERT_GE(voxels, 1000);
    const double ratio = enclosed_volume(volume, volume.field(1)) / voxels;
    RecordProperty("ratio" + std::to_string(number), std::to_string(ratio));
    EXPECT_NEAR(ratio, 1, 0.01) << voxels << " voxels";
  }
}

}  // namespace
}  // namespace isosplat
