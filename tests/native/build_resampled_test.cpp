#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/resampled_source.h"

namespace isosplat {
namespace {

constexpr Index3 kFrom{12, 9, 15};
constexpr uint64_t kMuch = uint64_t{1} << 30;

size_t count(Index3 n) {
  return static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * static_cast<size_t>(n.z);
}

VolumeGrid grid(Index3 voxels, Vec3d spacing, Vec3d origin = {}) {
  VolumeGrid made;
  made.voxels = voxels;
  made.spacing = spacing;
  made.origin = origin;
  return made;
}

/// Turned about all axes.
VolumeGrid turned(Index3 voxels, Vec3d spacing, Vec3d origin) {
  VolumeGrid made = grid(voxels, spacing, origin);
  made.direction = {0.8, -0.36, 0.48, 0.6, 0.48, -0.64, 0, 0.8, 0.6};
  return made;
}

/// The trilinear function of all voxels, straight from its definition. Up to half a voxel outside,
/// the nearest.
double trilinear(const VolumeGrid& of, const std::vector<float>& voxels, Vec3d world) {
  const Vec3d at = multiply_transposed(of.dual_edges(), world - of.origin);
  const auto weight = [](double position, int32_t voxel, int32_t n) {
    if (position < -0.500001 || position > n - 0.499999) return std::nan("");
    return std::max(0.0, 1 - std::abs(std::clamp(position, 0.0, n - 1.0) - voxel));
  };
  double sum = 0;
  size_t i = 0;
  for (int32_t z = 0; z < of.voxels.z; ++z) {
    for (int32_t y = 0; y < of.voxels.y; ++y) {
      for (int32_t x = 0; x < of.voxels.x; ++x, ++i) {
        const double w = weight(at.x, x, of.voxels.x) * weight(at.y, y, of.voxels.y) *
                         weight(at.z, z, of.voxels.z);
        if (std::isnan(w)) return w;
        if (w > 1e-5) sum += w * voxels[i];
      }
    }
  }
  return sum;
}

class BuildResampled : public ::testing::Test {
 protected:
  BuildResampled() : voxels(count(kFrom)) {
    std::mt19937 random(5);
    for (float& voxel : voxels) voxel = static_cast<float>(random() % 1000);
  }

  Result<std::unique_ptr<ResampledSource>> resample(const VolumeGrid& to, uint64_t memory = kMuch) {
    return ResampledSource::create("field", std::make_unique<ArraySource<float>>(from, voxels),
                                   from, to, memory);
  }

  /// The values at all voxels, read in portions of `slices`.
  static std::vector<double> read(VolumeSource& source, int32_t slices) {
    const Index3 n = source.header().grid.voxels;
    std::vector<double> values(count(n));
    const size_t slice = count({n.x, n.y, 1});
    for (int32_t z = 0; z < n.z; z += slices) {
      const int32_t read = std::min(slices, n.z - z);
      const auto done = source.read_slices(
          z, read,
          std::as_writable_bytes(std::span(values).subspan(slice * static_cast<size_t>(z),
                                                           slice * static_cast<size_t>(read))));
      EXPECT_TRUE(done) << done.error().message;
    }
    return values;
  }

  void expect_trilinear(const VolumeGrid& to, const std::vector<double>& values) {
    size_t i = 0, with_value = 0;
    for (int32_t z = 0; z < to.voxels.z; ++z) {
      for (int32_t y = 0; y < to.voxels.y; ++y) {
        for (int32_t x = 0; x < to.voxels.x; ++x, ++i) {
          const Vec3d index{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
          const double expected = trilinear(from, voxels, to.world(index));
          ASSERT_EQ(std::isnan(expected), std::isnan(values[i])) << x << ' ' << y << ' ' << z;
          if (std::isnan(expected)) continue;
          ASSERT_NEAR(values[i], expected, 1e-3) << x << ' ' << y << ' ' << z;
          ++with_value;
        }
      }
    }
    EXPECT_GT(with_value, count(to.voxels) / 20);
  }

  VolumeGrid from = turned(kFrom, {2, 1.5, 1}, {10, -20, 5});
  std::vector<float> voxels;
};

TEST_F(BuildResampled, IsTheTrilinearFunctionOnTurnedGrids) {
  const VolumeGrid to = turned({30, 14, 20}, {0.7, 1.3, 1.1}, {9, -20, 4});
  const VolumeGrid other = grid({25, 21, 17}, {1, 1, 1.5}, {2, -22, 3});
  for (const VolumeGrid& each : {to, other}) {
    const auto source = resample(each);
    ASSERT_TRUE(source) << source.error().message;
    expect_trilinear(each, read(**source, 5));
  }
}

TEST_F(BuildResampled, IsTheSameWithFewSlicesInMemoryAndByRows) {
  const VolumeGrid to = turned({30, 14, 20}, {0.7, 1.3, 1.1}, {9, -20, 4});
  const auto all = resample(to), few = resample(to, 20000);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_TRUE(few) << few.error().message;
  const auto expected = read(**all, 20);
  const auto same = [&](const std::vector<double>& found) {
    return std::memcmp(found.data(), expected.data(), found.size() * sizeof(double)) == 0;
  };
  EXPECT_TRUE(same(read(**few, 1)));
  EXPECT_TRUE(same(read(**few, 7)));
  std::vector<double> rows(30 * 4 * 3);
  ASSERT_TRUE((*few)->read_rows({2, 3, 5, 4}, std::as_writable_bytes(std::span(rows))));
  for (size_t z = 0; z < 3; ++z) {
    for (size_t i = 0; i < 120; ++i) {
      const double at = expected[(z + 2) * 30 * 14 + 5 * 30 + i], found = rows[z * 120 + i];
      EXPECT_TRUE(at == found || (std::isnan(at) && std::isnan(found))) << z << ' ' << i;
    }
  }
}

TEST_F(BuildResampled, KeepsTheVoxelsThatGridsShare) {
  from = grid(kFrom, {1, 1, 1}, {0.1, 0.2, 0.3});
  voxels[count({kFrom.x, kFrom.y, 3}) + 40] = std::nanf("");
  VolumeGrid to = grid({6, 5, 8}, {2, 2, 2}, from.origin);
  const auto source = resample(to);
  ASSERT_TRUE(source) << source.error().message;
  const auto values = read(**source, 8);
  size_t i = 0;
  for (size_t z = 0; z < 8; ++z) {
    for (size_t y = 0; y < 5; ++y) {
      for (size_t x = 0; x < 6; ++x, ++i) {
        EXPECT_EQ(values[i], voxels[(2 * z * 9 + 2 * y) * 12 + 2 * x]) << i;
      }
    }
  }
}

TEST_F(BuildResampled, HasNoValueWhereAVoxelAroundHasNone) {
  from = grid(kFrom, {1, 1, 1});
  voxels[(size_t{4} * 9 + 4) * 12 + 5] = std::nanf("");
  const VolumeGrid to = grid({23, 17, 29}, {0.5, 0.5, 0.5}, {0, 0, 0});
  const auto source = resample(to);
  ASSERT_TRUE(source) << source.error().message;
  const auto values = read(**source, 3);
  EXPECT_EQ(std::count_if(values.begin(), values.end(), [](double v) { return std::isnan(v); }),
            27);
}

TEST_F(BuildResampled, MeasuresItsError) {
  // A plane is the same on each grid. A kink inside of a cell is not.
  from = grid(kFrom, {1, 1, 1}, {1, 0, 0});
  const VolumeGrid to = grid({6, 9, 15}, {2, 1, 1}, {1, 0, 0});
  const auto set = [&](auto value) {
    for (size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<float>(value(i % 12));
  };
  set([](size_t x) { return 3 * x; });
  const auto measured = [&](const VolumeGrid& on) {
    const auto source = resample(on);
    EXPECT_TRUE(source) << source.error().message;
    return (*source)->measure().value();
  };
  EXPECT_LT(measured(to).max, 1e-4);
  EXPECT_EQ(measured(to).outside, 0);
  set([](size_t x) { return x % 2; });
  // Differences are those of a triangle of height 1, whose mean square is 1/3.
  EXPECT_NEAR(measured(to).max, 1, 0.01);
  EXPECT_NEAR(measured(to).rms, std::sqrt(1.0 / 3), 0.02);
  const VolumeGrid half = grid({12, 9, 15}, {1, 1, 1}, {1 + 5.5, 0, 0});
  EXPECT_NEAR(measured(half).outside, 5.0 / 11, 0.03);
}

TEST_F(BuildResampled, HasNoValuesElsewhereAndRefusesTooLittleMemory) {
  const auto elsewhere = resample(grid({5, 5, 5}, {1, 1, 1}, {1e6, 0, 0}));
  ASSERT_TRUE(elsewhere) << elsewhere.error().message;
  EXPECT_EQ((*elsewhere)->measure()->outside, 1);
  const auto values = read(**elsewhere, 5);
  EXPECT_TRUE(std::all_of(values.begin(), values.end(), [](double v) { return std::isnan(v); }));
  const auto little = resample(grid({25, 21, 17}, {1, 1, 1.5}, {2, -22, 3}), 1000);
  ASSERT_FALSE(little);
  EXPECT_EQ(little.error().status, Status::out_of_memory);
}

TEST_F(BuildResampled, ReachesHalfAVoxelBeyondWhateverTheRounding) {
  // Nodes of n cells of 0.1, whose values are at their centres: the outer nodes lie exactly half a
  // voxel outside.
  for (const int32_t n : {7, 10, 12, 16, 23, 30, 49}) {
    from = grid({n, 3, 3}, {0.1, 0.1, 0.1}, {0.05 - 0.7, 0.05, 0.05});
    voxels.assign(count(from.voxels), 1);
    const VolumeGrid nodes = grid({n + 1, 4, 4}, {0.1, 0.1, 0.1}, {-0.7, 0, 0});
    const auto source = resample(nodes);
    ASSERT_TRUE(source) << source.error().message;
    for (const double value : read(**source, 2)) ASSERT_EQ(value, 1) << n;
    // No farther, unless voxels of the new grid count.
    const VolumeGrid wide = grid({n + 3, 4, 4}, {0.1, 0.1, 0.1}, {-0.8, 0, 0});
    const auto values = read(**resample(wide), 4);
    EXPECT_TRUE(std::isnan(values[0]) && values[1] == 1 && std::isnan(values[n + 2]));
    const auto reaching = ResampledSource::create(
        "field", std::make_unique<ArraySource<float>>(from, voxels), from, wide, kMuch, {0.5, 1});
    ASSERT_TRUE(reaching);
    for (const double value : read(**reaching, 4)) ASSERT_EQ(value, 1) << n;
  }
}

TEST_F(BuildResampled, KeepsDifferencesOfLargeValues) {
  from = grid(kFrom, {1, 1, 1}, {0.5, 0, 0});
  std::vector<double> large(count(kFrom));
  for (size_t i = 0; i < large.size(); ++i) large[i] = 1e8 + static_cast<double>(i % 12);
  const VolumeGrid to = grid({10, 9, 15}, {1, 1, 1}, {1, 0, 0});
  const auto source = ResampledSource::create(
      "field", std::make_unique<ArraySource<double>>(from, large), from, to, kMuch);
  ASSERT_TRUE(source);
  const auto values = read(**source, 15);
  for (size_t i = 0; i < values.size(); ++i) {
    ASSERT_EQ(values[i], 1e8 + 0.5 + static_cast<double>(i % 10));
  }
}

TEST_F(BuildResampled, MeasuresWithinTheMemoryOfReading) {
  // All slices of the volume lie between two of the grid.
  from = grid({12, 9, 15}, {1, 1, 0.01}, {0, 0, 0.4});
  const VolumeGrid to = grid({12, 9, 2}, {1, 1, 1});
  const auto source = resample(to, 12 * 9 * 8 * 4);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_GT((*source)->measure()->outside, 0.5);
}

}  // namespace
}  // namespace isosplat
