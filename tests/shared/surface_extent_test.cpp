// Area and volume of spheres and half spaces against closed forms. Triangles of a sphere of radius
// r cells lie inside of it, and lose about 0.6 / r² of its volume. The bound for both is 1 / r².
#include "shared/core/mesh/surface_extent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace isosplat {
namespace {

/// The sums over the isosurface of f at 30000, block by block. f: of the position in the world.
SurfaceExtent extent_of(const VolumeGrid& grid, const std::function<double(Vec3d)>& f) {
  BlockMesher mesher;
  BlockMesh mesh;
  const LevelGrid level = level_grid(grid.voxels, 0);
  std::vector<QuantizedValue> voxels;  // x fastest
  for (int32_t z = 0; z < grid.voxels.z; ++z) {
    for (int32_t y = 0; y < grid.voxels.y; ++y) {
      for (int32_t x = 0; x < grid.voxels.x; ++x) {
        const double value = f(grid.world({double(x), double(y), double(z)}));
        voxels.push_back(static_cast<QuantizedValue>(std::lround(std::clamp(value, 0.0, 65534.0))));
      }
    }
  }
  SurfaceExtent extent(grid, 30000, *std::min_element(voxels.begin(), voxels.end()));
  const auto at = [&](Index3 i) {
    return voxels[size_t(i.x) +
                  size_t(grid.voxels.x) * (size_t(i.y) + size_t(grid.voxels.y) * size_t(i.z))];
  };
  for (int32_t bz = 0; bz < level.blocks.z; ++bz) {
    for (int32_t by = 0; by < level.blocks.y; ++by) {
      for (int32_t bx = 0; bx < level.blocks.x; ++bx) {
        const Index3 cells = block_cells(level, {bx, by, bz});
        const Index3 origin{bx * kBlockCells, by * kBlockCells, bz * kBlockCells};
        DecodedCells decoded;
        for (int32_t z = 0; z < cells.z; ++z) {
          for (int32_t y = 0; y < cells.y; ++y) {
            for (int32_t x = 0; x < cells.x; ++x) {
              CellCorners corners;
              for (int i = 0; i < 8; ++i) {
                corners[size_t(i)] = at(
                    {origin.x + x + (i & 1), origin.y + y + (i >> 1 & 1), origin.z + z + (i >> 2)});
              }
              const CellInterval interval = corner_interval(corners);
              if (!is_active(interval, 30000)) continue;
              decoded.cell.push_back(static_cast<uint32_t>(x | y << 6 | z << 12));
              decoded.corners.push_back(corners);
              decoded.interval.push_back(interval);
            }
          }
        }
        mesher.run(decoded, cells, origin, 30000, mesh);
        extent.add(decoded, mesh, origin);
      }
    }
  }
  return extent;
}

VolumeGrid grid_of(Index3 voxels) {
  VolumeGrid grid;
  grid.voxels = voxels;
  return grid;
}

/// 30000 on the sphere, greater inside (sign 1) or outside (sign −1).
std::function<double(Vec3d)> sphere(Vec3d centre, double radius, double sign) {
  return [=](Vec3d p) { return 30000 + sign * 500 * (radius - length(p - centre)); };
}

constexpr double kPi = std::numbers::pi;

TEST(SurfaceExtent, SpheresHaveTheirAreaAndVolume) {
  for (const double r : {10.0, 20.0, 30.0}) {
    const VolumeGrid grid = grid_of({80, 72, 70});
    const Vec3d centre{38.3, 35.6, 34.7};  // a sphere across several blocks
    const SurfaceExtent extent = extent_of(grid, sphere(centre, r, 1));
    const double bound = 1 / (r * r);
    EXPECT_NEAR(extent.area() / (4 * kPi * r * r), 1, bound) << r;
    EXPECT_NEAR(extent.volume_above() / (4 * kPi / 3 * r * r * r), 1, bound) << r;
    // The same sphere, as a hole in a solid.
    const SurfaceExtent hole = extent_of(grid, sphere(centre, r, -1));
    EXPECT_NEAR((hole.grid_volume() - hole.volume_above()) / (4 * kPi / 3 * r * r * r), 1, bound);
  }
}

// The faces of the grid close surfaces that they cut: spheres around a corner, an edge and a face.
TEST(SurfaceExtent, FacesOfTheGridCloseWhatTheyCut) {
  const double r = 13;
  const VolumeGrid grid = grid_of({36, 34, 38});
  const Vec3d last{35, 33, 37};
  for (int corner = 0; corner < 27; ++corner) {
    const auto along = [](int i, double end) { return i == 0 ? 0.0 : i == 1 ? end / 2 : end; };
    const Vec3d centre{along(corner % 3, last.x), along(corner / 3 % 3, last.y),
                       along(corner / 9, last.z)};
    int cuts = 0;
    for (const int i : {corner % 3, corner / 3 % 3, corner / 9}) cuts += i != 1;
    const double part = std::pow(0.5, cuts), bound = 1 / (r * r);
    for (const double sign : {1.0, -1.0}) {
      const SurfaceExtent extent = extent_of(grid, sphere(centre, r, sign));
      const double inside =
          sign > 0 ? extent.volume_above() : extent.grid_volume() - extent.volume_above();
      EXPECT_NEAR(extent.area() / (4 * kPi * r * r * part), 1, bound) << corner << ", " << sign;
      EXPECT_NEAR(inside / (4 * kPi / 3 * r * r * r * part), 1, bound) << corner << ", " << sign;
    }
  }
}

TEST(SurfaceExtent, PlanesAreExactInShearedGrids) {
  VolumeGrid grid = grid_of({20, 24, 18});
  grid.spacing = {0.5, 1.5, 2};
  grid.origin = {100, -50, 20};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0.28, 0, 0, 0.96};
  // Half of the grid along each axis: planes through its centre, on both sides.
  const Vec3d centre = grid.world({9.5, 11.5, 8.5});
  for (const Vec3d normal : {Vec3d{1, 0, 0}, Vec3d{0.3, -0.5, 0.2}, Vec3d{-0.2, 0.1, 0.9}}) {
    const SurfaceExtent extent =
        extent_of(grid, [&](Vec3d p) { return 30000 + 400 * dot(normal, p - centre); });
    EXPECT_NEAR(extent.volume_above() / extent.grid_volume(), 0.5, 2e-3);
  }
  EXPECT_NEAR(SurfaceExtent(grid, 0, 0).grid_volume(), 19 * 23 * 17 * 0.5 * 1.5 * 2 * 0.8 * 0.96,
              1e-9);
}

TEST(SurfaceExtent, WithoutASurfaceAllIsOnOneSide) {
  const VolumeGrid grid = grid_of({10, 10, 10});
  const SurfaceExtent below = extent_of(grid, [](Vec3d) { return 5.0; });
  EXPECT_EQ(below.area(), 0);
  EXPECT_EQ(below.volume_above(), 0);
  const SurfaceExtent above = extent_of(grid, [](Vec3d) { return 30001.0; });
  EXPECT_EQ(above.area(), 0);
  EXPECT_EQ(above.volume_above(), above.grid_volume());
}

// A single voxel on the other side has a surface, however small its part of a cell is. This also
// holds for the last voxel of the grid.
TEST(SurfaceExtent, OneVoxelOnTheOtherSide) {
  const VolumeGrid grid = grid_of({70, 67, 68});
  for (const Vec3d lone : {Vec3d{30, 30, 30}, Vec3d{0, 0, 0}, Vec3d{69, 66, 67}, Vec3d{69, 0, 67},
                           Vec3d{64, 66, 0}, Vec3d{68, 66, 67}, Vec3d{69, 65, 67}}) {
    for (const double sign : {1.0, -1.0}) {
      // A little octahedron: 1/1001 of the way to the voxels beside it.
      const SurfaceExtent extent = extent_of(
          grid, [&](Vec3d p) { return 30000 + sign * (length(p - lone) < 0.5 ? 1 : -1000); });
      const double above = extent.volume_above() / extent.grid_volume();
      EXPECT_NEAR(above, sign > 0 ? 0 : 1, 1e-9) << lone.x << ", " << lone.y << ", " << sign;
      EXPECT_GT(extent.area(), 0);
    }
  }
}

}  // namespace
}  // namespace isosplat
