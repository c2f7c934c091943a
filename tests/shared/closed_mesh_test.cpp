// Closed surfaces: each edge has two triangles, in opposite directions, for random values, planes
// and boxes. Volumes against closed forms, voxels, and the parts on both sides of a plane.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>

#include "shared/core/mesh/mesh_assembly.h"
#include "shared/core/mesh/polygon_triangles.h"
#include "shared/core/mesh/solid_region.h"
#include "shared/core/mesh/surface_extent.h"
#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

struct Volume {
  VolumeGrid grid;
  std::vector<QuantizedValue> voxels;  // x fastest

  Volume(const VolumeGrid& where, const std::function<double(Vec3d)>& f) : grid(where) {
    for (int32_t z = 0; z < grid.voxels.z; ++z) {
      for (int32_t y = 0; y < grid.voxels.y; ++y) {
        for (int32_t x = 0; x < grid.voxels.x; ++x) {
          const double value = f({double(x), double(y), double(z)});
          voxels.push_back(
              static_cast<QuantizedValue>(std::lround(std::clamp(value, 0.0, 65534.0))));
        }
      }
    }
  }

  /// Beyond the last voxel, it is repeated.
  QuantizedValue at(Index3 i) const {
    const auto x = size_t(std::min(i.x, grid.voxels.x - 1));
    const auto y = size_t(std::min(i.y, grid.voxels.y - 1));
    const auto z = size_t(std::min(i.z, grid.voxels.z - 1));
    return voxels[x + size_t(grid.voxels.x) * (y + size_t(grid.voxels.y) * z)];
  }
};

/// Decodes the active cells of a block of a level. Coarse voxels are every 2^level-th one.
DecodedCells cells_of(const Volume& volume, uint32_t level, Index3 origin, Index3 count,
                      float isovalue) {
  DecodedCells decoded;
  for (int32_t z = 0; z < count.z; ++z) {
    for (int32_t y = 0; y < count.y; ++y) {
      for (int32_t x = 0; x < count.x; ++x) {
        CellCorners corners;
        for (int i = 0; i < 8; ++i) {
          corners[size_t(i)] =
              volume.at({(origin.x + x + (i & 1)) << level, (origin.y + y + (i >> 1 & 1)) << level,
                         (origin.z + z + (i >> 2)) << level});
        }
        const CellInterval interval = corner_interval(corners);
        if (!is_active(interval, isovalue)) continue;
        decoded.cell.push_back(static_cast<uint32_t>(x | y << 6 | z << 12));
        decoded.corners.push_back(corners);
        decoded.interval.push_back(interval);
      }
    }
  }
  return decoded;
}

/// The surface of the solid in a region.
MeshPart solid(const Volume& volume, float isovalue, const SolidRegion& region,
               uint32_t level = 0) {
  const LevelGrid blocks = level_grid(volume.grid.voxels, level);
  MeshAssembly assembly(lattice_grid(volume.grid.voxels), level);
  BlockMesher mesher;
  mesher.keep_off_lattice_points(SolidRegion::kLeastDistance);
  const CellRegion cells = region.cells();
  MeshPart all;
  for (int32_t z = 0; z <= blocks.blocks.z + 1; ++z) {
    std::vector<MeshedBlock> layer;
    for (int32_t y = 0; z < blocks.blocks.z && y < blocks.blocks.y; ++y) {
      for (int32_t x = 0; x < blocks.blocks.x; ++x) {
        const Index3 count = block_cells(blocks, {x, y, z});
        MeshedBlock& block = layer.emplace_back();
        block.origin = {x * kBlockCells, y * kBlockCells, z * kBlockCells};
        DecodedCells decoded = cells_of(volume, level, block.origin, count, isovalue);
        cells.keep(decoded, block.origin, level);
        mesher.run(decoded, count, block.origin, isovalue, block.mesh);
      }
    }
    EXPECT_TRUE(assembly.add_layer(std::move(layer)));
    for (size_t i = 0; i < assembly.complete_parts(); ++i) {
      append_part(all, assembly.take_part(i));
    }
    assembly.drop_complete();
  }
  const auto closed = region.close(all);
  EXPECT_TRUE(closed) << closed.error().message;
  return all;
}

/// Expects that each edge has two triangles, in opposite directions.
void expect_closed(const MeshPart& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, size_t> uses;
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      ASSERT_LT(t[i], mesh.vertices.positions.size());
      ASSERT_NE(t[i], t[(i + 1) % 3]);
      ++uses[{t[i], t[(i + 1) % 3]}];
    }
  }
  for (const auto& [edge, count] : uses) {
    const auto reverse = uses.find({edge.second, edge.first});
    ASSERT_TRUE(reverse != uses.end() && count == 1);
  }
  ASSERT_EQ(mesh.vertices.positions.size(), mesh.vertices.normals.size());
}

double volume_of(const MeshPart& mesh) {
  double six = 0;
  const auto& at = mesh.vertices.positions;
  if (at.empty()) return 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    six += dot(at[a] - at[0], cross(at[b] - at[0], at[c] - at[0]));
  }
  return six / 6;
}

VolumeGrid cube(int32_t n) {
  return lattice_grid({n, n, n});
}

constexpr double kPi = std::numbers::pi;

std::function<double(Vec3d)> ball(Vec3d centre, double radius) {
  return [=](Vec3d p) { return 30000 + 500 * (radius - length(p - centre)); };
}

/// Values whose differences between neighbours are small, or as large as can be.
std::function<double(Vec3d)> random_values(RandomCells& random, uint32_t kind) {
  return [&random, kind](Vec3d p) {
    switch (kind % 4) {
      case 0:
        return double(random.integer(65535));
      case 1:  // the isovalue is a value of voxels
        return double(29999 + random.integer(3));
      case 2:
        return 30000 + 9000 * std::sin(p.x / 2) * std::cos(p.y / 3) + 8000 * std::sin(p.z / 2.5);
      default:
        return double(random.integer(6) == 0 ? 0 : 65534);
    }
  };
}

TEST(ClosedMesh, RandomVolumesAreClosedAndHaveTheirVolume) {
  RandomCells random(7);
  for (uint32_t i = 0; i < 200; ++i) {
    const VolumeGrid grid =
        lattice_grid({2 + int32_t(random.integer(9)), 2 + int32_t(random.integer(9)),
                      2 + int32_t(random.integer(9))});
    const Volume volume(grid, random_values(random, i));
    const float isovalue = 30000 + 0.5f * static_cast<float>(random.integer(2));
    const MeshPart mesh = solid(volume, isovalue, SolidRegion(grid, 0));
    ASSERT_NO_FATAL_FAILURE(expect_closed(mesh)) << i;
    if (mesh.triangles.empty()) continue;
    SurfaceExtent extent(grid, isovalue, 0);
    BlockMesher mesher;
    mesher.keep_off_lattice_points(SolidRegion::kLeastDistance);
    BlockMesh block;
    const Index3 cells{grid.voxels.x - 1, grid.voxels.y - 1, grid.voxels.z - 1};
    const DecodedCells decoded = cells_of(volume, 0, {}, cells, isovalue);
    mesher.run(decoded, cells, {}, isovalue, block);
    extent.add(decoded, block, {});
    EXPECT_NEAR(volume_of(mesh), extent.volume_above(), 1e-3 * extent.grid_volume()) << i;
  }
}

TEST(ClosedMesh, PartsOnBothSidesOfAPlaneMakeTheWhole) {
  RandomCells random(8);
  const auto share = [&] { return 2 * double(random.unit()) - 1; };
  for (uint32_t i = 0; i < 400; ++i) {
    const int32_t n = 3 + int32_t(random.integer(7));
    const VolumeGrid grid = cube(n);
    const Volume volume(grid, random_values(random, i));
    const float isovalue = 30000 + 0.5f * static_cast<float>(random.integer(2));
    Vec3d normal{share(), share(), share()};
    Vec3d through{double(random.unit()) * (n - 1), double(random.unit()) * (n - 1),
                  double(random.unit()) * (n - 1)};
    if (i % 3 == 0) {  // through lattice points: along faces, diagonals, and edges of cells
      normal = {double(random.integer(3)) - 1, double(random.integer(3)) - 1, 1};
      through = {double(random.integer(uint32_t(n))), double(random.integer(uint32_t(n))),
                 double(random.integer(uint32_t(n)))};
    }
    double sum = 0;
    for (const double sign : {1.0, -1.0}) {
      SolidRegion region(grid, 0);
      ASSERT_TRUE(region.clip({normal * sign, sign * dot(normal, through)}));
      const MeshPart mesh = solid(volume, isovalue, region);
      ASSERT_NO_FATAL_FAILURE(expect_closed(mesh)) << i;
      for (const Vec3d at : mesh.vertices.positions) {
        ASSERT_GE(sign * dot(normal, at - through) / length(normal), -1e-4);
      }
      sum += volume_of(mesh);
    }
    const double whole = volume_of(solid(volume, isovalue, SolidRegion(grid, 0)));
    EXPECT_NEAR(sum, whole, 1e-3 + 1e-3 * whole) << i;
  }
}

TEST(ClosedMesh, ManyPlanesAndBoxesLeaveClosedSurfaces) {
  RandomCells random(9);
  for (uint32_t i = 0; i < 200; ++i) {
    const int32_t n = 4 + int32_t(random.integer(8));
    VolumeGrid grid = cube(n);
    grid.spacing = {0.5, 2, 0.75};
    grid.origin = {-3, 10, 1e3};
    if (i % 2 == 0) grid.direction = {0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, -1};  // mirrored
    const Volume volume(grid, random_values(random, i));
    SolidRegion region(grid, 0);
    const auto within = [&] { return double(random.unit()) * (n - 1); };
    const Vec3d centre = grid.world({within(), within(), within()});
    if (i % 3 != 0) {
      const Vec3d half{0.2 + random.unit(), 0.5 + 4 * random.unit(), 0.5 + 2 * random.unit()};
      ASSERT_TRUE(region.clip_to_box(centre - half, centre + half));
    }
    for (uint32_t planes = random.integer(6); planes > 0; --planes) {
      const Vec3d normal{double(random.unit()) - 0.5, double(random.unit()) - 0.5,
                         double(random.unit()) - 0.5};
      ASSERT_TRUE(region.clip({normal, dot(normal, centre) - 0.3 * double(random.unit())}));
    }
    const MeshPart mesh = solid(volume, 30000, region);
    ASSERT_NO_FATAL_FAILURE(expect_closed(mesh)) << i;
    EXPECT_GE(volume_of(mesh), 0) << i;
  }
}

TEST(ClosedMesh, BallsHaveTheVolumeOfTheirParts) {
  const double r = 30;
  const Volume volume(cube(80), ball({39.3, 40.1, 38.7}, r));
  const double whole = 4 * kPi / 3 * r * r * r;
  SolidRegion half(volume.grid, 0);
  ASSERT_TRUE(half.clip({{1, 2, -2}, 39.3 + 2 * 40.1 - 2 * 38.7}));
  MeshPart mesh = solid(volume, 30000, half);
  expect_closed(mesh);
  EXPECT_NEAR(volume_of(mesh) / (whole / 2), 1, 1e-3);
  // A cap of height 12 with a side between lattice planes.
  SolidRegion cap(volume.grid, 0);
  ASSERT_TRUE(cap.clip_to_box({39.3 + r - 12, -100, -100}, {100, 100, 100}));
  mesh = solid(volume, 30000, cap);
  expect_closed(mesh);
  EXPECT_NEAR(volume_of(mesh) / (kPi * 12 * 12 * (3 * r - 12) / 3), 1, 2e-3);
}

TEST(ClosedMesh, TheOutsideOfABallEndsAtTheBordersOfTheVolume) {
  const double r = 30;
  const Vec3d centre{39.3, 40.1, 38.7};
  const Volume volume(cube(80), [&](Vec3d p) { return 60000 - ball(centre, r)(p); });
  const MeshPart mesh = solid(volume, 30000, SolidRegion(volume.grid, 0));
  expect_closed(mesh);
  EXPECT_NEAR(volume_of(mesh) / (79.0 * 79 * 79 - 4 * kPi / 3 * r * r * r), 1, 1e-3);
  // The twelve triangles of a box around the hole.
  size_t on_border = 0;
  for (const auto& t : mesh.triangles) {
    on_border += std::all_of(t.begin(), t.end(), [&](uint32_t v) {
      return length(mesh.vertices.positions[v] - centre) > r + 2;
    });
  }
  EXPECT_EQ(on_border, 12u);
}

TEST(ClosedMesh, ATorusThroughTheBorderHasItsVolume) {
  // Half of a torus: the volume ends at its plane of symmetry.
  const Volume volume(lattice_grid({101, 51, 41}), [](Vec3d p) {
    const double ring = std::hypot(p.x - 50, p.y) - 30;
    return 30000 + 900 * (12 - std::hypot(ring, p.z - 20));
  });
  const MeshPart mesh = solid(volume, 30000.5, SolidRegion(volume.grid, 0));
  expect_closed(mesh);
  EXPECT_NEAR(volume_of(mesh) / (kPi * kPi * 30 * 12 * 12), 1, 5e-3);
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) ++edges[std::minmax(t[i], t[(i + 1) % 3])];
  }
  EXPECT_EQ(mesh.vertices.positions.size() + mesh.triangles.size() - edges.size(), 2u);
}

TEST(ClosedMesh, CoarseLevelsEndAtTheLastVoxel) {
  const Volume volume(lattice_grid({38, 41, 46}), [](Vec3d p) { return 1000 * p.x; });
  for (const uint32_t level : {1u, 2u}) {
    const MeshPart mesh = solid(volume, 10500, SolidRegion(volume.grid, level), level);
    expect_closed(mesh);
    EXPECT_NEAR(volume_of(mesh), (37 - 10.5) * 40 * 45, 1);
  }
}

TEST(ClosedMesh, BlocksShareTheirClosedSurface) {
  RandomCells random(10);
  const Volume volume(lattice_grid({70, 12, 66}), random_values(random, 2));
  SolidRegion region(volume.grid, 0);
  ASSERT_TRUE(region.clip({{1, 1, 1}, 60.25}));
  const MeshPart mesh = solid(volume, 30000.5, region);
  EXPECT_GT(mesh.triangles.size(), 1000u);
  expect_closed(mesh);
}

TEST(ClosedMesh, RefusesWhatItCannotClose) {
  const VolumeGrid grid = cube(12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double huge = std::numeric_limits<double>::max();
  SolidRegion region(grid, 0);
  for (const HalfSpace& wrong :
       {HalfSpace{{0, 0, 0}, 1}, HalfSpace{{nan, 0, 1}, 1}, HalfSpace{{1, 0, 0}, nan},
        HalfSpace{{huge, huge, 0}, 1}, HalfSpace{{1e-300, 0, 0}, huge},
        HalfSpace{{1, 0, 0}, std::numeric_limits<double>::infinity()}}) {
    const auto clipped = region.clip(wrong);
    ASSERT_FALSE(clipped);
    EXPECT_EQ(clipped.error().status, Status::invalid_argument);
  }
  EXPECT_FALSE(region.clip_to_voxels({nan, 0, 0}, {1, 1, 1}));
  // A cell is missing in the middle.
  MeshPart mesh;
  mesh.vertices.positions = {{1.5, 1, 1}, {2, 1.5, 1}, {1.5, 2, 1.5}};
  mesh.vertices.normals.resize(3);
  mesh.triangles = {{0, 1, 2}};
  ASSERT_TRUE(region.clip({{1, 0, 0}, 1.75}));
  const auto closed = region.close(mesh);
  ASSERT_FALSE(closed);
  EXPECT_NE(closed.error().message.find("--open"), std::string::npos);
}

TEST(ClosedMesh, PlanesBesideTheVolumeLeaveAllOrNothing) {
  const Volume volume(cube(30), ball({15, 15, 15}, 10));
  for (const auto& [offset, is_all] : {std::pair{-1e6, true}, {1e6, false}, {-1e300, true}}) {
    SolidRegion region(volume.grid, 0);
    ASSERT_TRUE(region.clip({{0, 1, 0}, offset}));
    EXPECT_EQ(!solid(volume, 30000, region).triangles.empty(), is_all);
  }
  SolidRegion outside(volume.grid, 0);
  ASSERT_TRUE(outside.clip_to_box({100, 100, 100}, {200, 200, 200}));
  EXPECT_TRUE(solid(volume, 30000, outside).triangles.empty());
}

/// A loop appended to a polygon.
void append_loop(std::vector<PlanePoint>& points, std::vector<uint32_t>& next,
                 std::span<const PlanePoint> loop) {
  const auto first = static_cast<uint32_t>(points.size());
  for (uint32_t i = 0; i < loop.size(); ++i) {
    points.push_back(loop[i]);
    next.push_back(first + (i + 1) % static_cast<uint32_t>(loop.size()));
  }
}

double turn(PlanePoint a, PlanePoint b, PlanePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

TEST(PolygonTriangles, PolygonsWithHolesAreCoveredOnce) {
  RandomCells random(11);
  for (int round = 0; round < 100; ++round) {
    std::vector<PlanePoint> points, loop;
    std::vector<uint32_t> next;
    double area = 0;
    const auto star = [&](double x, double y, double size, bool is_hole) {
      loop.clear();
      const uint32_t count = 3 + random.integer(20);
      for (uint32_t i = 0; i < count; ++i) {
        const double angle = 2 * kPi * (i + 0.5 * double(random.unit())) / count;
        const double r = size * (0.3 + 0.7 * double(random.unit()));
        loop.push_back({x + r * std::cos(angle), y + r * std::sin(angle)});
      }
      if (is_hole) std::reverse(loop.begin(), loop.end());
      for (size_t i = 0; i < loop.size(); ++i) {
        area += turn({0, 0}, loop[i], loop[(i + 1) % loop.size()]) / 2;
      }
      append_loop(points, next, loop);
    };
    const std::array<PlanePoint, 4> square{{{0, 0}, {10, 0}, {10, 10}, {0, 10}}};
    append_loop(points, next, square);
    area += 100;
    for (int x = 0; x < 10; ++x) {
      for (int y = 0; y < 10; ++y) {
        if (random.integer(2) == 0) star(x + 0.5, y + 0.5, 0.45, true);
      }
    }
    star(20, 5, 4, false);
    const auto triangles = polygon_triangles(points, next);
    double covered = 0;
    for (const auto& [a, b, c] : triangles) {
      const double twice = turn(points[a], points[b], points[c]);
      EXPECT_GE(twice, -1e-9);
      covered += std::abs(twice) / 2;
    }
    EXPECT_NEAR(covered, area, 1e-9) << round;
  }
}

TEST(PolygonTriangles, AnyLoopsHaveEachSideOnce) {
  RandomCells random(12);
  for (int round = 0; round < 500; ++round) {
    std::vector<PlanePoint> points, loop;
    std::vector<uint32_t> next;
    const uint32_t range = 1 + random.integer(5);  // loops touch, cross, and repeat points
    for (uint32_t loops = 1 + random.integer(5); loops > 0; --loops) {
      loop.clear();
      for (uint32_t count = 3 + random.integer(12); count > 0; --count) {
        loop.push_back({double(random.integer(range)), double(random.integer(range))});
      }
      append_loop(points, next, loop);
    }
    std::map<std::pair<uint32_t, uint32_t>, int> surplus;
    for (const auto& t : polygon_triangles(points, next)) {
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t a = t[i], b = t[(i + 1) % 3];
        ASSERT_NE(a, b);
        ++surplus[{a, b}];
        --surplus[{b, a}];
      }
    }
    for (uint32_t v = 0; v < next.size(); ++v) {
      --surplus[{v, next[v]}];
      ++surplus[{next[v], v}];
    }
    for (const auto& [edge, count] : surplus) ASSERT_EQ(count, 0) << round;
  }
}

}  // namespace
}  // namespace isosplat
