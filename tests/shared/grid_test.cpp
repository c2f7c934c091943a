#include "shared/core/grid/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isosplat {
namespace {

TEST(Levels, HalveTheCellsUntilTheCoarsestIsSmall) {
  EXPECT_EQ(level_count({2, 2, 2}), 1u);
  EXPECT_EQ(level_count({17, 17, 17}), 1u);
  EXPECT_EQ(level_count({18, 2, 2}), 2u);
  EXPECT_EQ(level_count({33, 33, 33}), 2u);
  EXPECT_EQ(level_count({256, 256, 128}), 5u);
  EXPECT_EQ(level_count({kMaxVoxelsPerAxis, 2, 2}), 17u);
}

TEST(Levels, CoverTheVolumeWithLessThanOneCellOfOverhang) {
  for (const Index3 voxels : {Index3{2, 2, 2}, Index3{65, 64, 63}, Index3{66, 129, 2},
                              Index3{301, 324, 56}, Index3{1000, 3, 17}}) {
    const uint32_t levels = level_count(voxels);
    for (uint32_t l = 0; l < levels; ++l) {
      const LevelGrid grid = level_grid(voxels, l);
      EXPECT_EQ(grid.level, l);
      for (const auto& [v, c, b] : {std::tuple{voxels.x, grid.cells.x, grid.blocks.x},
                                    std::tuple{voxels.y, grid.cells.y, grid.blocks.y},
                                    std::tuple{voxels.z, grid.cells.z, grid.blocks.z}}) {
        EXPECT_GE(c << l, v - 1);
        EXPECT_LT((c - 1) << l, v - 1);
        EXPECT_GE(b * kBlockCells, c);
        EXPECT_LT((b - 1) * kBlockCells, c);
      }
    }
    const Index3 coarsest = level_grid(voxels, levels - 1).cells;
    EXPECT_LE(std::max({coarsest.x, coarsest.y, coarsest.z}), kCoarsestCells);
  }
}

TEST(Blocks, PartitionTheCellsOfALevel) {
  for (const Index3 voxels :
       {Index3{2, 2, 2}, Index3{65, 64, 63}, Index3{66, 129, 2}, Index3{130, 200, 65}}) {
    const LevelGrid grid = level_grid(voxels, 0);
    int64_t sum = 0;
    uint64_t count = 0;
    for (int32_t z = 0; z < grid.blocks.z; ++z) {
      for (int32_t y = 0; y < grid.blocks.y; ++y) {
        for (int32_t x = 0; x < grid.blocks.x; ++x, ++count) {
          const Index3 cells = block_cells(grid, {x, y, z});
          for (const int32_t c : {cells.x, cells.y, cells.z}) {
            EXPECT_GE(c, 1);
            EXPECT_LE(c, kBlockCells);
          }
          sum += int64_t{cells.x} * cells.y * cells.z;
        }
      }
    }
    EXPECT_EQ(count, grid.block_count());
    EXPECT_EQ(sum, int64_t{voxels.x - 1} * (voxels.y - 1) * (voxels.z - 1));
  }
}

TEST(Blocks, AreThinInThinVolumes) {
  EXPECT_EQ(block_cells(level_grid({65, 66, 67}, 0), {0, 1, 1}), (Index3{64, 1, 2}));
}

TEST(VolumeGrid, MapsVoxelsToTheWorld) {
  VolumeGrid grid;
  grid.voxels = {10, 20, 30};
  grid.spacing = {2, 3, 5};
  grid.origin = {-7, 11, 13};
  EXPECT_EQ(grid.world({0, 0, 0}), grid.origin);
  EXPECT_EQ(grid.world({1, 1, 1}), (Vec3d{-5, 14, 18}));
  EXPECT_EQ(grid.world({0.5, 0, 0}), (Vec3d{-6, 11, 13}));

  // x → y, y → z, z → x: the columns are the world directions of the voxel axes.
  grid.direction = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  EXPECT_EQ(grid.world({1, 0, 0}), (Vec3d{-7, 13, 13}));
  EXPECT_EQ(grid.world({0, 1, 0}), (Vec3d{-7, 11, 16}));
  EXPECT_EQ(grid.world({0, 0, 1}), (Vec3d{-2, 11, 13}));
}

// The gradient of a function equals its differences along the world axes, for any spacing and
// direction.
TEST(VolumeGrid, GradientsFollowTheWorld) {
  VolumeGrid grid;
  grid.voxels = {10, 10, 10};
  grid.spacing = {0.5, 2, 3};
  grid.origin = {1, 2, 3};
  const double s = std::sin(0.3), c = std::cos(0.3);
  grid.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  const Vec3d slope{3, -4, 5};  // f(world) = slope · world
  const auto f = [&](Vec3d index) { return dot(slope, grid.world(index)); };
  const Vec3d index_gradient{f({1, 0, 0}) - f({0, 0, 0}), f({0, 1, 0}) - f({0, 0, 0}),
                             f({0, 0, 1}) - f({0, 0, 0})};
  const Vec3d gradient = grid.world_gradient(index_gradient);
  EXPECT_NEAR(gradient.x, slope.x, 1e-12);
  EXPECT_NEAR(gradient.y, slope.y, 1e-12);
  EXPECT_NEAR(gradient.z, slope.z, 1e-12);
}

// Differences along world axes, on a grid whose axes are not perpendicular.
TEST(VolumeGrid, GradientsFollowTheWorldOnShearedGrids) {
  VolumeGrid grid;
  grid.spacing = {0.5, 2, 3};
  grid.origin = {1, 2, 3};
  grid.direction = {1, 0.6, 0, 0, 0.8, -0.28, 0, 0, 0.96};
  const Vec3d slope{3, -4, 5};  // f(world) = slope · world
  const auto f = [&](Vec3d index) { return dot(slope, grid.world(index)); };
  const Vec3d gradient = grid.world_gradient(
      {f({1, 0, 0}) - f({0, 0, 0}), f({0, 1, 0}) - f({0, 0, 0}), f({0, 0, 1}) - f({0, 0, 0})});
  EXPECT_LT(length(gradient - slope), 1e-12);
  // The transposed dual matrix maps a vector in the world to voxels.
  const Vec3d index = multiply_transposed(grid.dual_edges(), grid.world({4, 5, 6}) - grid.origin);
  EXPECT_LT(length(index - Vec3d{4, 5, 6}), 1e-12);
}

TEST(VolumeGrid, ReportsHowFarItsAxesAreFromPerpendicular) {
  EXPECT_EQ(shear_degrees(kIdentity3), 0);
  const double s = std::sin(0.3), c = std::cos(0.3);
  EXPECT_NEAR(shear_degrees({c, -s, 0, s, c, 0, 0, 0, 1}), 0, 1e-6);
  EXPECT_NEAR(shear_degrees({1, 0, 0, 0, 1, 0, 0, std::tan(0.25), 1}),
              0.25 * 180 / 3.14159265358979, 1e-9);
  EXPECT_NEAR(shear_degrees({5, 0, -3, 0, 2, 0, 0, 0, 3}), 45, 1e-9);  // columns of any length
}

TEST(VolumeGrid, RefusesAxesThatAreNotABasis) {
  EXPECT_TRUE(is_basis(kIdentity3));
  EXPECT_TRUE(is_basis({-1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_TRUE(is_basis({1, 0.6, 0, 0, 0.8, 0.6, 0, 0, 0.8}));
  EXPECT_FALSE(is_basis({1.001, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_FALSE(is_basis({1, 0, 0, 0, 0, 0, 0, 0, 1}));
  EXPECT_FALSE(is_basis({1, 0.6, 0.8, 0, 0.8, -0.6, 0, 0, 0}));  // in a plane
  EXPECT_FALSE(is_basis({1, 1 - 1e-8, 0, 0, 1e-4, 0, 0, 0, 1}));
  EXPECT_FALSE(is_basis({std::nan(""), 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_FALSE(is_basis({HUGE_VAL, 0, 0, 0, 1, 0, 0, 0, 1}));
}

TEST(ValueMapping, QuantizesIsovaluesAndBack) {
  EXPECT_EQ((ValueMapping{.offset = -32768}.quantized_isovalue(1000.5)), 33768.5f);
  const ValueMapping mapping{.offset = -1.5, .scale = 1.0 / 1024};
  EXPECT_EQ(mapping.quantized_isovalue(-1.5), 0.0f);
  EXPECT_EQ(mapping.quantized_isovalue(0), 1536.0f);
  EXPECT_EQ(mapping.value(1536), 0.0);
}

TEST(ValueMapping, AnIsovalueOnAValueIsItsQuantizedValue) {
  for (const double scale : {1.0, 2.0078, 0.1, 1e-3, 7.1098, 1.0 / 3, 1e-9, 3e7}) {
    for (const double offset : {0.0, -1024.0, -32768.0, -32768 * scale, 1234.5678, 1e6}) {
      const ValueMapping mapping{.offset = offset, .scale = scale};
      const double infinity = std::numeric_limits<double>::infinity();
      // Single precision distinguishes values only if the offset is not too large for the scale.
      const bool singles = std::abs(offset) + 65536 * scale < 0x1p21 * scale;
      for (int quantized = 0; quantized < 65536; quantized += quantized < 300 ? 1 : 997) {
        const auto c = static_cast<float>(quantized);
        const double value = mapping.value(quantized);
        SCOPED_TRACE(testing::Message() << offset << " + " << scale << " * " << quantized);
        ASSERT_EQ(mapping.quantized_isovalue(value), c);
        ASSERT_EQ(mapping.quantized_isovalue(offset - (-quantized * scale)), c);
        ASSERT_EQ(mapping.quantized_isovalue((quantized + offset / scale) * scale), c);
        if (singles) {
          const auto single = static_cast<float>(value);
          ASSERT_EQ(mapping.quantized_isovalue(static_cast<double>(single)), c);
          // Next to 0 there are numbers that only arise from the rounding of others.
          if (std::abs(value) > 0x1p-25 * (std::abs(offset) + 65536 * scale)) {
            ASSERT_LT(
                mapping.quantized_isovalue(static_cast<double>(std::nextafter(single, -HUGE_VALF))),
                c);
            ASSERT_GT(
                mapping.quantized_isovalue(static_cast<double>(std::nextafter(single, HUGE_VALF))),
                c);
          }
        }
        // The isovalue differs clearly from the value, but by less than single precision can
        // resolve at large quantized values.
        const double near = std::max({scale * 1e-6, std::abs(value) * 1e-6 * singles,
                                      (std::abs(offset) + 65536 * scale) * 0x1p-49});
        if (near > scale / 8) continue;
        ASSERT_LT(mapping.quantized_isovalue(value - near), c);
        ASSERT_GT(mapping.quantized_isovalue(value - near), c - 1);
        ASSERT_GT(mapping.quantized_isovalue(value + near), c);
        ASSERT_LT(mapping.quantized_isovalue(value + near), c + 1);
      }
      EXPECT_LT(mapping.quantized_isovalue(-infinity), 0);
      EXPECT_GT(mapping.quantized_isovalue(infinity), 65535);
      EXPECT_LT(mapping.quantized_isovalue(offset - scale / 2), 0);
      EXPECT_GT(mapping.quantized_isovalue(offset + 65535.5 * scale), 65535);
      EXPECT_TRUE(std::isnan(mapping.quantized_isovalue(std::nan(""))));
    }
  }
}

}  // namespace
}  // namespace isosplat
