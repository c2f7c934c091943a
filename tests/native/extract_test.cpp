// Points of a noisy volume, on perpendicular and sheared grids, against the cells taken one by one.
#include "native/extract/extract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "native/build/array_source.h"
#include "shared/sampling/sample.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

constexpr Index3 kVoxels{70, 40, 30};
constexpr double kIsovalue = 120.5;

/// A ball that noise has eaten: many cells whose gradient says little.
const std::vector<uint8_t>& noisy_voxels() {
  static const std::vector<uint8_t> voxels = [] {
    std::mt19937 random(5);
    std::vector<uint8_t> result;
    for (int32_t z = 0; z < kVoxels.z; ++z) {
      for (int32_t y = 0; y < kVoxels.y; ++y) {
        for (int32_t x = 0; x < kVoxels.x; ++x) {
          const double r = std::hypot(x - 34.5, y - 19.5, z - 14.5);
          const double value = 250 - 10 * r + static_cast<double>(random() % 90) - 45;
          result.push_back(static_cast<uint8_t>(std::clamp(value, 0.0, 255.0)));
        }
      }
    }
    return result;
  }();
  return voxels;
}

CellCorners corners_of(Index3 cell) {
  CellCorners corners;
  for (int32_t i = 0; i < 8; ++i) {
    const int32_t x = cell.x + (i & 1), y = cell.y + (i >> 1 & 1), z = cell.z + (i >> 2);
    corners[static_cast<size_t>(i)] =
        noisy_voxels()[static_cast<size_t>((z * kVoxels.y + y) * kVoxels.x + x)];
  }
  return corners;
}

struct Point {
  Vec3d position, normal;
};

Vec3d as_double(Vec3f v) {
  return {v.x, v.y, v.z};
}

class Extract : public testing::TestWithParam<Matrix3d> {
 protected:
  void SetUp() override {
    grid_.voxels = kVoxels;
    grid_.spacing = {1, 1.5, 2};
    grid_.origin = {-100, 50, 25};
    grid_.direction = GetParam();
    const auto path = folder_.path() / "noisy.isosplat";
    ASSERT_TRUE(build_store_file<uint8_t>(grid_, noisy_voxels(), path));
    auto opened = StoreFile::open(path);
    ASSERT_TRUE(opened) << opened.error().message;
    store_ = std::move(*opened);
  }

  std::vector<Point> points(const ProjectionOptions& projection, uint32_t level = 0) {
    std::vector<Point> result;
    const auto count =
        extract_points(*store_, kIsovalue, projection, {level, 2}, [&](const PointArrays& some) {
          for (size_t i = 0; i < some.positions.size(); ++i) {
            result.push_back({some.positions[i], as_double(some.normals[i])});
          }
          return Result<void>{};
        });
    EXPECT_TRUE(count);
    EXPECT_EQ(*count, result.size());
    return result;
  }

  Vec3d index(Vec3d world) const {
    return multiply_transposed(grid_.dual_edges(), world - grid_.origin);
  }

  /// The active cells, by place.
  std::vector<Index3> active_cells() const {
    std::vector<Index3> cells;
    for (int32_t z = 0; z < kVoxels.z - 1; ++z) {
      for (int32_t y = 0; y < kVoxels.y - 1; ++y) {
        for (int32_t x = 0; x < kVoxels.x - 1; ++x) {
          if (is_active(corner_interval(corners_of({x, y, z})), kIsovalue)) {
            cells.push_back({x, y, z});
          }
        }
      }
    }
    return cells;
  }

  /// The paper's approximate projection of a cell's centre, in the world, from finite differences;
  /// nothing where it is dropped.
  std::optional<Vec3d> projected(Index3 cell) const {
    const Trilinear f(corners_of(cell));
    const auto value = [&](Vec3d in_cell) {
      return double(f.at({float(in_cell.x), float(in_cell.y), float(in_cell.z)}).value);
    };
    const Vec3d low{double(cell.x), double(cell.y), double(cell.z)}, middle{0.5, 0.5, 0.5};
    const Vec3d centre = grid_.world(low + middle);
    const auto along = [&](Vec3d world_axis) {
      const Vec3d step = multiply_transposed(grid_.dual_edges(), world_axis) * 0.125;
      return (value(middle + step) - value(middle - step)) / 0.25;
    };
    const Vec3d gradient{along({1, 0, 0}), along({0, 1, 0}), along({0, 0, 1})};
    const double squared = dot(gradient, gradient);
    if (squared < 1e-6) return std::nullopt;
    const Vec3d step = gradient * ((kIsovalue - value(middle)) / squared);
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d at{double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)};
      farthest = std::max(farthest, length(grid_.world(low + at) - centre));
    }
    if (length(step) > farthest) return std::nullopt;
    return centre + step;
  }

  TemporaryFolder folder_;
  VolumeGrid grid_;
  std::unique_ptr<StoreFile> store_;
};

TEST_P(Extract, GivesOnePointInsideOfEachActiveCell) {
  const std::vector<Index3> cells = active_cells();
  ASSERT_GT(cells.size(), 5000u);
  for (const bool exact : {false, true}) {
    const std::vector<Point> found = points({exact, Displaced::clamp});
    ASSERT_EQ(found.size(), cells.size());
    // Each cell takes one of the points that lie in it, or at its faces: those inside first.
    std::map<std::array<int32_t, 3>, int> inside;
    size_t at_faces = 0;
    for (const Point& point : found) {
      const Vec3d p = index(point.position);
      const Vec3d cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
      const double margin = std::min({p.x - cell.x, cell.x + 1 - p.x, p.y - cell.y,
                                      cell.y + 1 - p.y, p.z - cell.z, cell.z + 1 - p.z});
      if (margin < 1e-4) {
        ++at_faces;
      } else {
        ++inside[{int32_t(cell.x), int32_t(cell.y), int32_t(cell.z)}];
      }
      EXPECT_TRUE(std::abs(length(point.normal) - 1) < 1e-5 || length(point.normal) == 0);
    }
    size_t active = 0;
    for (const Index3& cell : cells) {
      const auto there = inside.find({cell.x, cell.y, cell.z});
      if (there == inside.end()) continue;
      EXPECT_EQ(there->second, 1);
      ++active;
    }
    EXPECT_EQ(active, inside.size()) << "points inside of cells that are not active";
    EXPECT_EQ(active + at_faces, cells.size());
    EXPECT_LT(at_faces, cells.size() / 2);
  }
}

TEST_P(Extract, DroppingFollowsThePaper) {
  std::vector<Vec3d> expected;
  size_t dropped = 0;
  for (const Index3& cell : active_cells()) {
    if (const auto p = projected(cell)) {
      expected.push_back(*p);
    } else {
      ++dropped;
    }
  }
  const std::vector<Point> found = points({false, Displaced::drop});
  EXPECT_EQ(found.size(), expected.size());
  EXPECT_GT(dropped, expected.size() / 50);  // the volume is noisy indeed
  const auto sorted = [](std::vector<Vec3d> list) {
    std::sort(list.begin(), list.end(),
              [](Vec3d a, Vec3d b) { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); });
    return list;
  };
  std::vector<Vec3d> positions;
  for (const Point& point : found) positions.push_back(point.position);
  const std::vector<Vec3d> ours = sorted(positions), truth = sorted(expected);
  size_t apart = 0;
  for (size_t i = 0; i < std::min(ours.size(), truth.size()); ++i) {
    apart += length(ours[i] - truth[i]) > 1e-2;
  }
  EXPECT_LT(apart, truth.size() / 1000) << "but for points that sort otherwise when rounded";
}

TEST_P(Extract, GivesOnePointForEachActiveCellOfCoarseLevels) {
  const float isocode = store_->info().mapping.isocode(kIsovalue);
  for (const uint32_t level : {1u, 2u}) {
    const auto selection = store_->chunks_for(level, isocode, isocode);
    ASSERT_TRUE(selection);
    uint64_t active = 0;
    std::vector<ChunkSamples> chunks;
    ASSERT_TRUE(extract_samples(*store_, kIsovalue, {level, 1}, chunks));
    for (const ChunkSamples& chunk : chunks) {
      for (const PackedSample& sample : chunk.samples) {
        active += is_active(unpack_sample(sample).interval, isocode);
      }
    }
    ASSERT_GT(active, 100u);
    for (const Displaced displaced : {Displaced::clamp, Displaced::drop}) {
      EXPECT_EQ(points({false, displaced}, level).size(), active);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, Extract,
                         testing::Values(kIdentity3, Matrix3d{1, 0.6, 0, 0, 0.8, 0.6, 0, 0, 0.8}));

// On a sheared grid, a sphere of the world: points on it, normals along its radii.
TEST(ExtractSheared, PointsAndNormalsAreThoseOfTheWorld) {
  VolumeGrid grid;
  grid.voxels = {81, 81, 61};
  grid.spacing = {1, 1.1, 1.4};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0.6, 0, 0, 0.8};
  const Vec3d centre = grid.world({40, 40, 30});
  constexpr double kRadius = 18;
  std::vector<uint16_t> voxels;
  for (int32_t z = 0; z < grid.voxels.z; ++z) {
    for (int32_t y = 0; y < grid.voxels.y; ++y) {
      for (int32_t x = 0; x < grid.voxels.x; ++x) {
        const double r = length(grid.world({double(x), double(y), double(z)}) - centre);
        voxels.push_back(static_cast<uint16_t>(100 * r + 0.5));
      }
    }
  }
  const TemporaryFolder folder;
  ASSERT_TRUE(build_store_file<uint16_t>(grid, voxels, folder.path() / "ball.isosplat"));
  const auto store = StoreFile::open(folder.path() / "ball.isosplat");
  ASSERT_TRUE(store);
  for (const bool exact : {false, true}) {
    size_t count = 0;
    const auto done = extract_points(
        **store, 100 * kRadius, {exact, Displaced::clamp}, {}, [&](const PointArrays& some) {
          for (size_t i = 0; i < some.positions.size(); ++i, ++count) {
            const Vec3d out = some.positions[i] - centre;
            EXPECT_NEAR(length(out), kRadius, 0.06);
            // Values grow outwards, and normals point towards smaller ones.
            EXPECT_LT(dot(out, as_double(some.normals[i])) / length(out),
                      -std::cos(6 * 3.14159265 / 180));
          }
          return Result<void>{};
        });
    ASSERT_TRUE(done);
    EXPECT_GT(count, 4000u);
  }
}

}  // namespace
}  // namespace isosplat
