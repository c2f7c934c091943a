#include "shared/core/preprocess/label_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "shared/core/preprocess/label_distance.h"
#include "tests/shared/test_labels.h"

namespace isosplat {
namespace {

using test::crossing;
using test::field_of;
using test::TestLabels;

constexpr int kMargin = 2;

/// The volume above the isovalue of the trilinear field, from 6³ points a cell.
double enclosed_volume(const TestLabels& volume, const std::vector<std::uint8_t>& field) {
  constexpr int kPoints = 6;
  double inside = 0;
  for (std::uint32_t z = 0; z + 1 < volume.size; ++z)
    for (std::uint32_t y = 0; y + 1 < volume.size; ++y)
      for (std::uint32_t x = 0; x + 1 < volume.size; ++x) {
        std::array<double, 8> corners{};
        int above = 0;
        for (std::uint32_t i = 0; i < 8; ++i) {
          corners[i] = field[volume.at(x + (i & 1U), y + (i >> 1U & 1U), z + (i >> 2U))];
          above += corners[i] > kLabelFieldIsovalue ? 1 : 0;
        }
        if (above == 0) continue;
        for (int point = 0; point < kPoints * kPoints * kPoints; ++point) {
          const double u = (point % kPoints + 0.5) / kPoints;
          const double v = (point / kPoints % kPoints + 0.5) / kPoints;
          const double w = (point / kPoints / kPoints + 0.5) / kPoints;
          double value = 0;
          for (std::uint32_t i = 0; i < 8; ++i)
            value += ((i & 1U) != 0 ? u : 1 - u) * ((i >> 1U & 1U) != 0 ? v : 1 - v) *
                     (i >> 2U != 0 ? w : 1 - w) * corners[i];
          inside += value > kLabelFieldIsovalue ? 1 : 0;
        }
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

TEST(LabelField, DistancesAreThoseOfASearch) {
  std::mt19937 random(11);
  for (const unsigned one_in : {2U, 30U, 700U}) {
    const std::int32_t edge = 13;
    std::vector<std::uint16_t> labels(edge * edge * edge);
    for (std::uint16_t& label : labels) label = random() % one_in == 0 ? 1 : 0;
    LabelTile tile;
    tile.first = {-2, 1, -1};
    tile.size = {edge + 3, edge, edge + 2};
    const auto is_label = [&](Vec3<int> p) {
      const bool is_inside = std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) < edge;
      return is_inside && labels[static_cast<std::size_t>((p.z * edge + p.y) * edge + p.x)] == 1;
    };
    compute_distances({labels, {edge, edge, edge}}, 1, tile);
    std::size_t i = 0;
    for (int z = 0; z < tile.size.z; ++z)
      for (int y = 0; y < tile.size.y; ++y)
        for (int x = 0; x < tile.size.x; ++x, ++i) {
          const Vec3<int> at{x + tile.first.x, y + tile.first.y, z + tile.first.z};
          double nearest = 100;
          for (int k = 0; k < tile.size.z; ++k)
            for (int j = 0; j < tile.size.y; ++j)
              for (int l = 0; l < tile.size.x; ++l) {
                const Vec3<int> other{l + tile.first.x, j + tile.first.y, k + tile.first.z};
                if (is_label(other) != is_label(at))
                  nearest = std::min(nearest, std::hypot(l - x, j - y, k - z));
              }
          const double expected = std::min(nearest - 0.5, 6.0) * (is_label(at) ? 1 : -1);
          ASSERT_NEAR(tile.values[i] / 256.0, expected, 1 / 256.0) << "voxel " << i;
          const LabelTile::Range near = tile.near[tile.row_number(y, z)];
          ASSERT_TRUE(std::abs(expected) == 6 || (x >= near.begin && x < near.end));
        }
  }
}

TEST(LabelField, DoesNotDependOnTheSlabs) {
  TestLabels volume(30);
  volume.add_ellipsoid(1, {14, 15, 13}, {9, 7, 10});
  const LabelBox box{{-2, 0, 1}, {30, 28, 29}};
  const auto whole = field_of(volume.labels, {30, 30, 30}, 1, box, 29);
  for (const std::int32_t slab : {1, 3, 13}) {
    EXPECT_EQ(field_of(volume.labels, {30, 30, 30}, 1, box, slab), whole);
  }
}

/// Boxes of more than 218 voxels along an axis have several tiles.
TEST(LabelField, TilesAgreeWithTheWhole) {
  const Index3 size{330, 20, 24};
  std::vector<std::uint16_t> labels(330 * 20 * 24);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const double x = static_cast<double>(i % 330);
    const double y = static_cast<double>(i / 330 % 20) - 10 + std::sin(x / 13);
    const double z = static_cast<double>(i / (330UL * 20)) - 12 - std::cos(x / 17);
    labels[i] = std::hypot(y, z) < 6 + std::sin(x / 40) ? 1 : 0;
  }
  const auto along_x = field_of(labels, size, 1, {{-2, -2, -2}, {334, 24, 28}}, 28);
  std::vector<std::uint16_t> turned(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    turned[(i % 330 * 24 + i / (330UL * 20)) * 20 + i / 330 % 20] = labels[i];
  }
  // The bands along z differ, and are read in slabs.
  const auto along_z = field_of(turned, {20, 24, 330}, 1, {{-2, -2, -2}, {24, 28, 334}}, 65);
  const auto middle = field_of(labels, size, 1, {{60, -2, -2}, {210, 24, 28}}, 28);
  int different = 0;
  for (std::size_t i = 0; i < along_x.size(); ++i) {
    const std::size_t x = i % 334;
    const std::size_t y = i / 334 % 24;
    const std::size_t z = i / (334UL * 24);
    // The order of the axes matters a little, and so do the ends of the middle part.
    ASSERT_NEAR(along_x[i], along_z[(x * 28 + z) * 24 + y], 5);
    if (x < 62 + 40 || x >= 62 + 210 - 40) continue;
    const int difference = along_x[i] - middle[(z * 24 + y) * 210 + x - 62];
    different += difference == 0 ? 0 : 1;
    ASSERT_LE(std::abs(difference), 1) << x;
  }
  EXPECT_LT(different, 200);
}

TEST(LabelField, MemoryIsBounded) {
  const auto bytes = [](Index3 size) {
    return LabelField({}, 1, {{0, 0, 0}, size}).memory_bytes();
  };
  EXPECT_LT(bytes({20, 20, 20}), 120'000);
  EXPECT_LT(bytes({500, 500, 4000}), 120'000'000);
  EXPECT_LT(bytes({2000, 2000, 4000}), 200'000'000);
}

/// The field of the other voxels is the negative field, also for voxels in random order.
TEST(LabelField, IsOdd) {
  std::mt19937 random(12);
  TestLabels volume(20);
  volume.add_ellipsoid(1, {8, 9, 11}, {6, 7, 5});
  for (int i = 0; i < 1000; ++i) volume.labels[random() % volume.labels.size()] ^= 1U;
  const std::vector<std::uint8_t> label = volume.field(1);
  const std::vector<std::uint8_t> rest = volume.field(0);
  for (std::size_t i = 0; i < label.size(); ++i)
    ASSERT_EQ(label[i] + rest[i], 2 * kLabelFieldIsovalue) << i;
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

/// Three labels meet along curves: a ball that is divided by a plane, in a background. Their
/// surfaces cross the same lattice edges, but not at the same place.
TEST(LabelField, MismatchAtTripleLines) {
  TestLabels volume(64);
  volume.add(1, [](double x, double y, double z) {
    return std::hypot(x - 31.3, y - 32.2, z - 31.8) <= 24 && x + 0.3 * y + 0.1 * z < 44;
  });
  volume.add(2, [](double x, double y, double z) {
    return std::hypot(x - 31.3, y - 32.2, z - 31.8) <= 24 && x + 0.3 * y + 0.1 * z >= 44;
  });
  std::array<std::vector<std::uint8_t>, 3> fields;
  for (std::uint16_t label = 0; label < 3; ++label) fields.at(label) = volume.field(label);
  double sum = 0;
  double largest = 0;
  double largest_far = 0;
  double near_sum = 0;
  int near_edges = 0;
  int edges = 0;
  for (std::uint32_t z = 1; z + 1 < volume.size; ++z)
    for (std::uint32_t y = 1; y + 1 < volume.size; ++y)
      for (std::uint32_t x = 1; x + 1 < volume.size; ++x)
        for (const std::size_t step :
             {volume.at(1, 0, 0), volume.at(0, 1, 0), volume.at(0, 0, 1)}) {
          const std::size_t i = volume.at(x, y, z);
          const std::size_t j = i + step;
          const std::uint16_t a = volume.labels[i];
          const std::uint16_t b = volume.labels[j];
          if (a == b) continue;
          // The two fields are distances in steps with opposite signs.
          const auto gap = [&](std::size_t voxel) {
            return std::abs(fields.at(a)[voxel] + fields.at(b)[voxel] - 2 * kLabelFieldIsovalue) /
                   double{kLabelFieldSteps};
          };
          const double mismatch = (gap(i) + gap(j)) / 2;
          sum += mismatch;
          largest = std::max(largest, mismatch);
          ++edges;
          const double from_middle = std::hypot(x - 31.3, y - 32.2, z - 31.8);
          if (a == 0 || b == 0) continue;
          if (from_middle > 21) {
            near_sum += mismatch;
            ++near_edges;
          } else if (from_middle < 12) {
            largest_far = std::max(largest_far, mismatch);
          }
        }
  RecordProperty("mean", std::to_string(sum / edges));
  RecordProperty("largest", std::to_string(largest));
  RecordProperty("near", std::to_string(near_sum / near_edges));
  RecordProperty("far", std::to_string(largest_far));
  EXPECT_LT(sum / edges, 0.05);
  EXPECT_LT(largest, 1);
  EXPECT_LT(near_sum / near_edges, 0.3);  // at most three voxels from the third label
  EXPECT_LT(largest_far, 0.16);           // at least twelve voxels from it
}

/// Checks the volume within the surface of label 1.
void expect_volume(const TestLabels& volume, double tolerance, const std::string& what) {
  const double voxels = volume.count(1);
  ASSERT_GE(voxels, 1000) << what;
  EXPECT_NEAR(enclosed_volume(volume, volume.field(1)) / voxels, 1, tolerance)
      << what << ", " << voxels << " voxels";
}

TEST(LabelField, VolumesOfSurfacesAgreeWithVoxelCounts) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> radius(6.3, 11);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (int number = 0; number < 8; ++number) {
    TestLabels volume(32);
    const Vec3<double> centre{16 + shift(random), 16 + shift(random), 16 + shift(random)};
    volume.add_ellipsoid(1, centre, {radius(random), radius(random), radius(random)});
    expect_volume(volume, 0.003, "ellipsoid");
  }
  for (const double thickness : {1.2, 2.0, 3.0}) {
    TestLabels volume(56);
    volume.add(1, [&](double x, double y, double z) {
      return std::hypot(x - 28, y - 27) < 23 &&
             std::abs(z - 28 - 0.23 * (x - 28) - 0.11 * (y - 27)) <= thickness / 2;
    });
    // A sheet of one voxel loses some of its rim.
    expect_volume(volume, thickness < 1.5 ? 0.05 : 0.005, "sheet");
  }
  for (const double across : {2.6, 3.5}) {
    TestLabels volume(64);
    volume.add(1, [&](double x, double y, double z) {
      return std::abs(z - 32) < 28 && x > 4 && y > 4 && x < 60 &&
             std::hypot(x - 32 - 15 * std::sin(z / 15), y - 30 - 0.2 * (z - 32)) <= across;
    });
    expect_volume(volume, 0.005, "vessel");
  }
}

}  // namespace
}  // namespace isosplat
