// The coarse levels of stores of distances: nothing thin vanishes, and thick structures stay where
// they are.

#include "shared/core/preprocess/distance_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/preprocess/coarsen.h"
#include "shared/core/preprocess/label_field.h"

namespace isosplat {
namespace {

constexpr int32_t kIsovalue = kLabelFieldIsovalue;

/// A level of voxels, x fastest, and the true intervals of its cells.
struct Level {
  LevelGrid grid;
  std::vector<uint8_t> voxels, intervals;

  uint8_t at(Index3 p) const {
    const Index3 n = grid.cells;
    return voxels[static_cast<size_t>((p.z * (n.y + 1) + p.y) * (n.x + 1) + p.x)];
  }
};

class DistanceLevelsTest : public ::testing::Test {
 protected:
  /// Level 0 of a volume of distances (in voxels, positive inside), and its coarser levels.
  void build(Index3 voxels, const std::function<double(Vec3d)>& distance) {
    levels_.clear();
    const LevelGrid grid = level_grid(voxels, 0);
    Level& first = levels_.emplace_back(Level{grid, {}, {}});
    for (int32_t z = 0; z < voxels.z; ++z) {
      for (int32_t y = 0; y < voxels.y; ++y) {
        for (int32_t x = 0; x < voxels.x; ++x) {
          const double steps = distance({double(x), double(y), double(z)}) * kLabelFieldSteps;
          const long limited = std::clamp(std::lround(steps), -31l, 31l);
          first.voxels.push_back(static_cast<uint8_t>(kIsovalue + limited));
        }
      }
    }
    for (uint32_t level = 1; level < level_count(voxels); ++level) coarsen(voxels, level);
  }

  void coarsen(Index3 voxels, uint32_t level) {
    const Level& fine = levels_.back();
    Layer layer{fine.grid};
    layer.bits = 8;
    layer.voxels = reinterpret_cast<const std::byte*>(fine.voxels.data());
    layer.voxel_box = voxel_slices(fine.grid, 0, fine.grid.cells.z + 1);
    if (level > 1) {
      layer.intervals = reinterpret_cast<const std::byte*>(fine.intervals.data());
      layer.cell_box = cell_slices(fine.grid, 0, fine.grid.cells.z);
    }
    layer.only_isovalue = QuantizedValue{kIsovalue};
    layer.coarse_levels = &distance_levels_;
    Level coarse{level_grid(voxels, level), {}, {}};
    coarse.voxels.resize(voxel_slices(coarse.grid, 0, coarse.grid.cells.z + 1).count());
    coarse.intervals.resize(2 * cell_slices(coarse.grid, 0, coarse.grid.cells.z).count());
    const CoarserLayer coarser{coarse.grid, reinterpret_cast<std::byte*>(coarse.voxels.data()),
                               voxel_slices(coarse.grid, 0, coarse.grid.cells.z + 1),
                               reinterpret_cast<std::byte*>(coarse.intervals.data()),
                               cell_slices(coarse.grid, 0, coarse.grid.cells.z)};
    GatheredBlock block;
    const Index3 blocks = fine.grid.blocks;
    for (int32_t b = 0; b < blocks.x * blocks.y * blocks.z; ++b) {
      gather_block(layer, {b % blocks.x, b / blocks.x % blocks.y, b / blocks.x / blocks.y}, block);
      if (level > 1) distance_levels_.set_intervals(layer, block);
      check_intervals(fine, block);
      coarsen_block(layer, block, coarser);
    }
    levels_.push_back(std::move(coarse));
  }

  /// A cell is active if its corners are on both sides of the surface.
  void check_intervals(const Level& level, const GatheredBlock& block) {
    size_t i = 0, missing = 0;
    for (int32_t z = 0; z < block.cells.z; ++z) {
      for (int32_t y = 0; y < block.cells.y; ++y) {
        for (int32_t x = 0; x < block.cells.x; ++x, ++i) {
          const CellInterval interval = block.intervals[i];
          int low = 255, high = 0;
          for (int32_t c = 0; c < 8; ++c) {
            const int value = level.at(block.index * kBlockCells +
                                       Index3{x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)});
            low = std::min(low, value);
            high = std::max(high, value);
          }
          const bool crosses = low <= kIsovalue && kIsovalue < high;
          missing += crosses && !(interval.min <= low && high <= interval.max);
        }
      }
    }
    EXPECT_EQ(missing, 0u) << "level " << level.grid.level;
  }

  /// The voxels inside at a level that have no voxel of the next level inside at a corner of the
  /// cells that contain them.
  uint64_t lost(size_t level) const {
    const Level &fine = levels_[level], &coarse = levels_[level + 1];
    uint64_t lost = 0;
    const Index3 n = fine.grid.cells, m = coarse.grid.cells;
    for (int32_t z = 0; z <= n.z; ++z) {
      for (int32_t y = 0; y <= n.y; ++y) {
        for (int32_t x = 0; x <= n.x; ++x) {
          if (fine.at({x, y, z}) <= kIsovalue) continue;
          bool found = false;
          for (int32_t c = 0; c < 8; ++c) {
            const Index3 corner{std::min((x + (c & 1)) / 2, m.x),
                                std::min((y + (c >> 1 & 1)) / 2, m.y),
                                std::min((z + (c >> 2)) / 2, m.z)};
            found |= coarse.at(corner) > kIsovalue;
          }
          lost += !found;
        }
      }
    }
    return lost;
  }

  DistanceLevels distance_levels_{kLabelFieldDistances};
  std::vector<Level> levels_;
};

TEST_F(DistanceLevelsTest, ThinStructuresRemain) {
  const Index3 voxels{97, 81, 89};
  const Vec3d middle{48, 40, 44};
  const auto sheet = [&](Vec3d p) {
    const double cap = p.x - 20;
    return std::min(0.6 - std::abs(length(p - middle) - 33.3), cap);
  };
  const auto tube = [&](Vec3d p) {
    const Vec3d q = p - middle;
    const double across = std::hypot(std::hypot(q.x, q.y) - 29.5, q.z - 0.3 * q.x);
    return 1.0 - across;
  };
  const auto slanted = [&](Vec3d p) {
    return 0.6 - std::abs(dot(p - middle, Vec3d{0.48, 0.6, 0.64}));
  };
  const auto in_box = [&](auto f) {
    return [=](Vec3d p) {
      const Vec3d q{std::min(p.x, 96 - p.x), std::min(p.y, 80 - p.y), std::min(p.z, 88 - p.z)};
      return std::min(f(p), std::min({q.x, q.y, q.z}) - 2.5);
    };
  };
  const std::function<double(Vec3d)> all[] = {in_box(sheet), in_box(tube), in_box(slanted)};
  for (const auto& distance : all) {
    build(voxels, distance);
    for (size_t level = 0; level + 1 < levels_.size(); ++level) {
      EXPECT_EQ(lost(level), 0u) << "structure " << (&distance - all) << ", level " << level;
    }
  }
}

TEST_F(DistanceLevelsTest, ThickStructuresStayWhereTheyAre) {
  const Vec3d middle{48.3, 47.6, 48.1};
  const double radius = 30;
  build({97, 97, 97}, [&](Vec3d p) { return radius - length(p - middle); });
  for (size_t level = 1; level < 3; ++level) {
    const double size = double(1 << level);
    double most = 0, sum = 0;
    int count = 0;
    const Index3 n = levels_[level].grid.cells;
    for (int32_t z = 0; z <= n.z; ++z) {
      for (int32_t y = 0; y <= n.y; ++y) {
        for (int32_t x = 0; x < n.x; ++x) {
          const int a = levels_[level].at({x, y, z}) - kIsovalue;
          const int b = levels_[level].at({x + 1, y, z}) - kIsovalue;
          if ((a > 0) == (b > 0)) continue;
          const Vec3d at = Vec3d{x + double(a) / (a - b), double(y), double(z)} * size;
          const double error = (length(at - middle) - radius) / size;
          most = std::max(most, std::abs(error));
          sum += error;
          ++count;
        }
      }
    }
    ASSERT_GT(count, 100);
    EXPECT_LT(most, 0.35) << "level " << level;
    EXPECT_LT(std::abs(sum / count), 0.06) << "level " << level;
  }
}

TEST_F(DistanceLevelsTest, SurfacesAreClosedAtTheFaces) {
  build({97, 81, 89}, [](Vec3d p) {
    return 0.7 - std::hypot(p.y - 3, p.z - 85) - std::max(std::abs(p.x - 48) - 40, 0.0);
  });
  for (const Level& level : levels_) {
    uint64_t inside = 0;
    const Index3 n = level.grid.cells;
    for (int32_t z = 0; z <= n.z; ++z) {
      for (int32_t y = 0; y <= n.y; ++y) {
        for (int32_t x = 0; x <= n.x; ++x) {
          const bool is_on_face = x % n.x == 0 || y % n.y == 0 || z % n.z == 0;
          inside += is_on_face && level.at({x, y, z}) > kIsovalue;
        }
      }
    }
    EXPECT_EQ(inside, 0u) << "level " << level.grid.level;
  }
}

}  // namespace
}  // namespace isosplat
