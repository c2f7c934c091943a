#include "shared/core/preprocess/label_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace isosplat {
namespace {

constexpr int kMargin = 2;

/// The field, computed in slabs of `slab` slices.
std::vector<std::uint8_t> field_of(const std::vector<std::uint16_t>& labels, Index3 size,
                                   std::uint16_t label, const LabelBox& box,
                                   std::int32_t slab = 5) {
  const std::size_t row_size = LabelVolume::row_size(size.x);
  const auto voxels = static_cast<std::size_t>(size.x);
  std::vector<std::uint16_t> rows(labels.size() / voxels * row_size);
  for (std::size_t row = 0; row * voxels < labels.size(); ++row)
    std::copy_n(labels.begin() + static_cast<std::ptrdiff_t>(row * voxels), voxels,
                rows.begin() + static_cast<std::ptrdiff_t>(row * row_size + LabelVolume::kBefore));
  LabelField field({rows, size}, label, box);
  const auto slice = static_cast<std::size_t>(box.size.x) * static_cast<std::size_t>(box.size.y);
  std::vector<std::uint8_t> values(slice * static_cast<std::size_t>(box.size.z));
  for (std::int32_t z = 0; z < box.size.z; z += slab) {
    const std::int32_t count = std::min(slab, box.size.z - z);
    field.compute(z, count,
                  std::span(values).subspan(slice * static_cast<std::size_t>(z),
                                            slice * static_cast<std::size_t>(count)));
  }
  return values;
}

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
    return field_of(labels, {edge, edge, edge}, label, {{0, 0, 0}, {edge, edge, edge}});
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

/// The definition in label_field.h, voxel by voxel.
int defined_value(const TestLabels& volume, std::uint16_t label, Vec3<int> at) {
  constexpr int kKernel[] = {-1, 2, 6, 2, -1};
  std::map<std::uint16_t, int> weights;
  std::uint16_t centre = 0;
  for (int i = 0; i < 125; ++i) {
    const int x = at.x + i % 5 - 2, y = at.y + i / 5 % 5 - 2, z = at.z + i / 25 - 2;
    const auto edge = static_cast<int>(volume.size);
    const bool is_inside = std::min({x, y, z}) >= 0 && std::max({x, y, z}) < edge;
    const std::uint16_t here =
        is_inside ? volume.labels[static_cast<std::size_t>((z * edge + y) * edge + x)]
                  : std::uint16_t{0};
    weights[here] += kKernel[i % 5] * kKernel[i / 5 % 5] * kKernel[i / 25];
    if (i == 62) centre = here;
  }
  if (!weights.contains(label)) return 0;
  const int own = weights[label];
  weights.erase(label);
  if (weights.empty()) return 62;
  int other = -1000;
  for (const auto& [ignored, weight] : weights) other = std::max(other, weight);
  const int distance = 31 * (own - other) / 512;
  return 31 + (centre == label ? std::clamp(distance, 10, 31) : std::clamp(distance, -31, -10));
}

TEST(LabelField, IsAsDefinedForAnySlabsAndLabels) {
  std::mt19937 random(11);
  for (const unsigned labels : {2U, 3U, 5U, 40U}) {
    TestLabels volume(9);
    for (std::uint16_t& label : volume.labels)
      label = static_cast<std::uint16_t>(random() % labels);
    // A uniform part, so that some voxels have one or two labels around them.
    for (std::size_t i = 0; i < volume.labels.size() / 2; ++i) volume.labels[i] = 1;
    for (const std::int32_t slab : {1, 3, 13}) {
      const std::vector<std::uint8_t> field =
          field_of(volume.labels, {9, 9, 9}, 1, {{-2, -2, -2}, {13, 13, 13}}, slab);
      for (int i = 0; i < 13 * 13 * 13; ++i)
        ASSERT_EQ(field[static_cast<std::size_t>(i)],
                  defined_value(volume, 1, {i % 13 - 2, i / 13 % 13 - 2, i / 169 - 2}))
            << labels << " labels, slabs of " << slab << ", voxel " << i;
    }
  }
}

TEST(LabelField, SeparatesTheVoxelsOfALabelInRandomVolumes) {
  std::mt19937 random(7);
  for (int volume_number = 0; volume_number < 20; ++volume_number) {
    TestLabels volume(12);
    for (std::uint16_t& label : volume.labels)
      label = static_cast<std::uint16_t>(random() % 4 * 10922);
    for (const int label : {0, 10922, 21844, 32766})
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
      field_of(labels, {3, 3, 3}, 5, {{kFirst, kFirst, kFirst}, {kEdge, kEdge, kEdge}});
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
