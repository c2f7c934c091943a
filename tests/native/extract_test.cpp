// Compares the points of a noisy volume, on perpendicular and sheared grids, with points computed
// cell by cell.
#include "native/extract/extract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <tuple>
#include <utility>

#include "native/builder/array_source.h"
#include "shared/core/sampling/sample.h"
#include "shared/core/sampling/smooth_gradients.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

constexpr Index3 kVoxels{70, 40, 30};
constexpr double kIsovalue = 120.5;

/// A ball with strong noise: many cells with unreliable gradients.
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

  /// The active cells, x fastest.
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

  /// The paper's approximate projection of a cell's centre, computed in world coordinates by finite
  /// differences. Also returns the length of the step in units of the displacement threshold, which
  /// is infinite if there is no gradient.
  std::pair<Vec3d, double> projected(Index3 cell) const {
    const Trilinear f(corners_of(cell));
    const auto value = [&](Vec3d in_cell) {
      return double(f.at({float(in_cell.x), float(in_cell.y), float(in_cell.z)}).value);
    };
    const Vec3d low{double(cell.x), double(cell.y), double(cell.z)}, middle{0.5, 0.5, 0.5};
    const Vec3d centre = grid_.world(low + middle);
    // Along a line the function is a cubic, so central differences over two distances are exact.
    const auto along = [&](Vec3d world_axis) {
      const Vec3d step = multiply_transposed(grid_.dual_edges(), world_axis) * 0.25;
      const auto slope = [&](double far) {
        return (value(middle + step * far) - value(middle - step * far)) / (0.5 * far);
      };
      return (4 * slope(1) - slope(2)) / 3;
    };
    const Vec3d gradient{along({1, 0, 0}), along({0, 1, 0}), along({0, 0, 1})};
    const double squared = dot(gradient, gradient);
    if (squared < 1e-6) return {centre, HUGE_VAL};
    const Vec3d step = gradient * ((kIsovalue - value(middle)) / squared);
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d at{double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)};
      farthest = std::max(farthest, length(grid_.world(low + at) - centre));
    }
    return {centre + step, length(step) / farthest};
  }

  TemporaryFolder folder_;
  VolumeGrid grid_;
  std::shared_ptr<StoreFile> store_;
};

TEST_P(Extract, GivesOnePointInsideOfEachActiveCell) {
  std::vector<Index3> truth = active_cells();
  ASSERT_GT(truth.size(), 5000u);
  // Samples and points have the same order: the cells of the active samples are those of the
  // points.
  std::vector<ChunkSamples> chunks;
  ASSERT_TRUE(extract_samples(*store_, kIsovalue, {0, 2}, chunks));
  std::vector<Index3> cells;
  for (const ChunkSamples& chunk : chunks) {
    for (const PackedSample& packed : chunk.samples) {
      const UnpackedSample sample = unpack_sample(packed);
      if (!is_active(sample.interval, kIsovalue)) continue;
      const Index3 block = chunk.chunk.block.index;
      cells.push_back(block * kBlockCells + sample.cell);
    }
  }
  for (const bool exact : {false, true}) {
    const std::vector<Point> found = points({exact, Displaced::clamp});
    ASSERT_EQ(found.size(), truth.size());
    ASSERT_EQ(found.size(), cells.size());
    for (size_t i = 0; i < found.size(); ++i) {
      const Vec3d p = index(found[i].position);
      const auto is_inside = [](double at, int32_t cell) {
        return at > cell - 1e-4 && at < cell + 1 + 1e-4;
      };
      EXPECT_TRUE(is_inside(p.x, cells[i].x) && is_inside(p.y, cells[i].y) &&
                  is_inside(p.z, cells[i].z))
          << i;
      const double length_of_normal = length(found[i].normal);
      EXPECT_TRUE(std::abs(length_of_normal - 1) < 1e-5 || length_of_normal == 0);
    }
  }
  const auto sort = [](std::vector<Index3>& list) {
    std::sort(list.begin(), list.end(),
              [](Index3 a, Index3 b) { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); });
  };
  sort(cells);
  sort(truth);
  EXPECT_EQ(cells, truth);
}

TEST_P(Extract, DroppingFollowsThePaper) {
  std::multimap<int32_t, Vec3d> found;  // by position along x
  for (const Point& point : points({false, Displaced::drop})) {
    found.emplace(static_cast<int32_t>(std::floor(point.position.x)), point.position);
  }
  size_t kept = 0, dropped = 0, undecided = 0;
  for (const Index3& cell : active_cells()) {
    const auto [position, thresholds] = projected(cell);
    if (thresholds > 1.0001) {
      ++dropped;
      continue;
    }
    const auto place = static_cast<int32_t>(std::floor(position.x));
    bool is_there = false;
    for (auto p = found.lower_bound(place - 1); p != found.upper_bound(place + 1); ++p) {
      is_there = is_there || length(p->second - position) < 1e-3;
    }
    if (thresholds > 0.9999) {  // rounding decides whether it is dropped
      ++undecided;
      continue;
    }
    ++kept;
    EXPECT_TRUE(is_there) << "cell " << cell.x << " " << cell.y << " " << cell.z;
  }
  EXPECT_GE(found.size(), kept);
  EXPECT_LE(found.size(), kept + undecided);
  EXPECT_LT(undecided, kept / 100);
  EXPECT_GT(dropped, kept / 50);  // the volume is noisy indeed
}

TEST_P(Extract, GivesOnePointForEachActiveCellOfCoarseLevels) {
  const float quantized_isovalue = store_->info().mapping.quantized_isovalue(kIsovalue);
  for (const uint32_t level : {1u, 2u}) {
    const auto selection = store_->chunks_for(level, quantized_isovalue, quantized_isovalue);
    ASSERT_TRUE(selection);
    uint64_t active = 0;
    std::vector<ChunkSamples> chunks;
    ASSERT_TRUE(extract_samples(*store_, kIsovalue, {level, 1}, chunks));
    for (const ChunkSamples& chunk : chunks) {
      for (const PackedSample& sample : chunk.samples) {
        active += is_active(unpack_sample(sample).interval, quantized_isovalue);
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

// A sphere in the world, sampled on a sheared grid: points are on it, and normals along its radii.
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
    double distance = 0, farthest = 0, min_cosine = 1;
    const auto done = extract_points(
        **store, 100 * kRadius, {exact, Displaced::clamp}, {}, [&](const PointArrays& some) {
          for (size_t i = 0; i < some.positions.size(); ++i, ++count) {
            const Vec3d out = some.positions[i] - centre;
            const double off = std::abs(length(out) - kRadius);
            distance += off;
            farthest = std::max(farthest, off);
            // Values grow outwards, and normals point towards smaller ones.
            min_cosine = std::min(min_cosine, -dot(out, as_double(some.normals[i])) / length(out));
          }
          return Result<void>{};
        });
    // If a step leads out of the cell, the point stays on a face of the cell.
    EXPECT_LT(distance / static_cast<double>(count), 0.1);
    EXPECT_LT(farthest, 0.7);
    EXPECT_GT(min_cosine, std::cos(6 * 3.14159265 / 180));
    ASSERT_TRUE(done);
    EXPECT_GT(count, 4000u);
  }
}

// The volume has several blocks along all axes, in three layers. Chunks also have cells of the band
// that the isosurface does not cross; these contribute as well.
TEST(ExtractSmooth, NormalsAreSumsOverAllBlocks) {
  VolumeGrid grid;
  grid.voxels = {140, 75, 150};
  grid.spacing = {1, 1.5, 2};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0.6, 0, 0, 0.8};
  std::mt19937 random(3);
  std::vector<uint8_t> voxels;
  for (int32_t z = 0; z < grid.voxels.z; ++z) {
    for (int32_t y = 0; y < grid.voxels.y; ++y) {
      for (int32_t x = 0; x < grid.voxels.x; ++x) {
        const double wave = std::sin(0.11 * x) + std::sin(0.13 * y) + std::sin(0.09 * z);
        voxels.push_back(static_cast<uint8_t>(128 + 30 * wave + double(random() % 6)));
      }
    }
  }
  const TemporaryFolder folder;
  ASSERT_TRUE(build_store_file<uint8_t>(grid, voxels, folder.path() / "waves.isosplat"));
  const auto store = StoreFile::open(folder.path() / "waves.isosplat");
  ASSERT_TRUE(store);
  const Matrix3d dual = grid.dual_edges();
  for (const uint32_t level : {0u, 1u}) {
    SCOPED_TRACE(level);
    // The reference: the same sums over all cells of all chunks, by their positions.
    std::vector<ChunkSamples> chunks;
    ASSERT_TRUE(extract_samples(**store, kIsovalue, {level, 2}, chunks));
    ASSERT_GE(chunks.size(), level == 0 ? 18u : 2u);
    SmoothGradients gradients;
    size_t inactive = 0;
    for (const ChunkSamples& chunk : chunks) {
      for (const PackedSample& packed : chunk.samples) {
        const UnpackedSample sample = unpack_sample(packed);
        gradients.add(level, chunk.chunk.block.index * kBlockCells + sample.cell, sample.corners);
        inactive += !is_active(sample.interval, kIsovalue);
      }
    }
    EXPECT_GT(inactive, 100u);
    size_t count = 0, at_borders = 0;
    double least_cosine = 1;
    const auto done =
        extract_points(**store, kIsovalue, {}, {level, 2}, [&](const PointArrays& some) {
          for (size_t i = 0; i < some.positions.size(); ++i, ++count) {
            const Vec3d at = multiply_transposed(dual, some.positions[i] - grid.origin);
            const Vec3d sum = multiply(dual, gradients.at(at));
            const Vec3d normal = as_double(some.normals[i]);
            EXPECT_NEAR(length(normal), 1, 1e-5);
            least_cosine = std::min(least_cosine, -dot(sum, normal) / length(sum));
            const double block = kBlockCells << level;
            const auto near_border = [&](double x) {
              return std::abs(x - block * std::round(x / block)) < 1;
            };
            at_borders += near_border(at.x) && near_border(at.z);
          }
          return Result<void>{};
        });
    ASSERT_TRUE(done);
    EXPECT_GT(count, level == 0 ? 20000u : 3000u);
    EXPECT_GT(at_borders, level == 0 ? 20u : 2u);
    // Samples of coarse levels have their corners clamped to the cell's interval.
    EXPECT_GT(least_cosine, level == 0 ? 1 - 1e-6 : 0.99);
  }
}

TEST_P(Extract, ExactNormalsAreThoseOfEachCell) {
  // In a noisy cell, the point is exactly where the ray along the gradient meets the surface.
  const ProjectionOptions projection{true, Displaced::clamp};
  size_t count = 0, differ = 0;
  std::vector<Vec3f> smooth;
  ASSERT_TRUE(extract_points(*store_, kIsovalue, projection, {0, 2}, [&](const PointArrays& some) {
    smooth.insert(smooth.end(), some.normals.begin(), some.normals.end());
    return Result<void>{};
  }));
  ASSERT_TRUE(
      extract_points(*store_, kIsovalue, projection, {0, 2, false}, [&](const PointArrays& some) {
        for (size_t i = 0; i < some.positions.size(); ++i) {
          const Vec3d at = index(some.positions[i]);
          const auto low = [](double x) { return static_cast<int32_t>(std::floor(x)); };
          const Index3 cell{low(at.x), low(at.y), low(at.z)};
          const Vec3d p = at - Vec3d{double(cell.x), double(cell.y), double(cell.z)};
          const bool is_inside =
              std::min({p.x, p.y, p.z}) > 1e-3 && std::max({p.x, p.y, p.z}) < 0.999;
          const Vec3f in_cell{float(p.x), float(p.y), float(p.z)};
          const auto [value, gradient] = Trilinear(corners_of(cell)).at(in_cell);
          // If the ray of a point does not meet the surface, the point is elsewhere.
          if (!is_inside || std::abs(value - kIsovalue) > 0.01) continue;
          const Vec3d normal = as_double(some.normals[i]);
          const Vec3d expected = grid_.world_gradient(as_double(gradient));
          EXPECT_GT(-dot(normal, expected), 0.9999 * length(expected)) << i;
          differ += dot(normal, as_double(smooth[count + i])) < 0.99;
        }
        count += some.positions.size();
        return Result<void>{};
      }));
  EXPECT_EQ(count, smooth.size());
  EXPECT_GT(differ, 1000u);
}

}  // namespace
}  // namespace isosplat
