// Unstructured meshes: shape functions, and the adaptive grids that are made of them.

#include <gtest/gtest.h>

#include "shared/core/unstructured/resample.h"
#include "tests/shared/mesh_fixture.h"

namespace isosplat::mesh_test {
namespace {

constexpr Box kUnit{{0, 0, 0}, {1, 1, 1}};

double linear(Vec3d p) {
  return 3 * p.x - 2 * p.y + p.z + 5;
}

double waves(Vec3d p) {
  return std::sin(4 * p.x) * std::cos(3 * p.y) + p.z * p.z;
}

/// A cell of each shape with moved corners, far from the origin.
CellGeometry random_cell(CellShape shape, std::mt19937& random) {
  UnstructuredMesh mesh;
  const Division divisions[] = {Division::tetrahedra, Division::pyramids, Division::wedges,
                                Division::hexahedra};
  std::uniform_real_distribution<double> moved(-0.15, 0.15);
  add_block(mesh, {{100, 200, -50}, {101, 201, -49}}, {1, 1, 1},
            divisions[static_cast<size_t>(shape)], [&](Vec3d p) {
              return p + Vec3d{moved(random), moved(random), moved(random)};
            });
  return mesh.geometry(0);
}

/// The value of a mesh by a search through all cells, without bins. Nothing outside.
std::optional<double> brute_value(const UnstructuredMesh& mesh, Vec3d at) {
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    if (const auto weights = weights_in_cell(mesh.geometry(cell), at)) {
      return mesh.value(cell, *weights);
    }
  }
  return std::nullopt;
}

Vec3d random_point(std::mt19937& random, const Box& box) {
  std::uniform_real_distribution<double> one(0, 1);
  const Vec3d size = box.high - box.low;
  const double x = one(random), y = one(random), z = one(random);
  return box.low + Vec3d{size.x * x, size.y * y, size.z * z};
}

TEST(Unstructured, WeightsAreTheInverseOfTheShapeFunctions) {
  std::mt19937 random(1);
  for (int32_t round = 0; round < 2000; ++round) {
    const auto shape = static_cast<CellShape>(round % 4);
    const CellGeometry cell = random_cell(shape, random);
    Vec3d at = random_point(random, kUnit);
    if (shape == CellShape::tetrahedron) at = at * (1.0 / 3);
    if (shape == CellShape::wedge) at = {at.x / 2, at.y / 2, at.z};
    if (shape == CellShape::pyramid) at = {at.x * at.z, at.y * at.z, at.z};
    const CornerWeights expected = shape_weights(shape, at);
    Vec3d point{0, 0, 0};
    double sum = 0;
    for (size_t i = 0; i < static_cast<size_t>(cell.count()); ++i) {
      point = point + cell.corners[i] * expected[i];
      sum += expected[i];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    const auto found = weights_in_cell(cell, point);
    ASSERT_TRUE(found) << "shape " << round % 4 << " at " << at.x << ' ' << at.y << ' ' << at.z;
    for (size_t i = 0; i < 8; ++i) EXPECT_NEAR((*found)[i], expected[i], 1e-8);
    // Corners are inside too, also the apex of a pyramid.
    for (size_t i = 0; i < static_cast<size_t>(cell.count()); ++i) {
      const auto corner = weights_in_cell(cell, cell.corners[i]);
      ASSERT_TRUE(corner) << "shape " << round % 4 << " corner " << i;
      EXPECT_NEAR((*corner)[i], 1, 1e-5);
    }
    EXPECT_FALSE(weights_in_cell(cell, cell.corners[0] + Vec3d{-2, 0, 0}));
  }
}

TEST(Unstructured, VolumesAreThoseOfTheCells) {
  for (const Division division : {Division::hexahedra, Division::tetrahedra, Division::wedges,
                                  Division::pyramids, Division::mixed}) {
    UnstructuredMesh mesh;
    add_block(mesh, {{1, 2, 3}, {2, 4, 6}}, {2, 3, 2}, division);
    double sum = 0;
    for (size_t cell = 0; cell < mesh.cells(); ++cell) sum += volume_of(mesh.geometry(cell));
    EXPECT_NEAR(sum, 6, 1e-12);
  }
}

TEST(Unstructured, LinearFunctionsAreExact) {
  for (const Division division : {Division::hexahedra, Division::tetrahedra, Division::wedges,
                                  Division::pyramids, Division::mixed}) {
    std::mt19937 random(2);
    for (const bool is_moved : {false, true}) {
      // Faces of mixed cells match in their geometry alone: a quadrilateral and two triangles.
      if (is_moved && division == Division::mixed) continue;
      UnstructuredMesh mesh;
      add_block(mesh, kUnit, {5, 4, 3}, division, [&](Vec3d p) {
        const bool is_inner = p.x > 0 && p.y > 0 && p.z > 0 && p.x < 1 && p.y < 1 && p.z < 1;
        if (!is_moved || !is_inner) return p;
        return p + random_point(random, {{-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04}});
      });
      set_values(mesh, linear);
      const auto resampled = resample(mesh, {});
      ASSERT_TRUE(resampled) << resampled.error().message;
      const ResampleError error = measure_error(mesh, *resampled);
      EXPECT_LT(error.max, 1e-6);
      EXPECT_EQ(error.outside, 0);
      EXPECT_GE(error.points, mesh.cells());
      for (int32_t i = 0; i < 300; ++i) {
        const Vec3d at = random_point(random, kUnit);
        const auto value = value_at(*resampled, at);
        ASSERT_TRUE(value);
        EXPECT_NEAR(*value, linear(at), 1e-6);
      }
    }
  }
}

TEST(Unstructured, EqualBoxesBecomeThemselves) {
  UnstructuredMesh mesh;
  add_block(mesh, {{-1, 0, 2}, {0.75, 2.25, 3.5}}, {7, 9, 6}, Division::hexahedra);
  set_values(mesh, waves);
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled);
  EXPECT_EQ(resampled->grid.cells(0), (Index3{7, 9, 6}));
  const ResampleError error = measure_error(mesh, *resampled);
  EXPECT_LT(error.max, 1e-9);
  EXPECT_EQ(error.outside, 0);
}

TEST(Unstructured, TheErrorIsBelowTheLimitAtRandomPoints) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {9, 9, 9}, Division::tetrahedra);
  set_values(mesh, waves);
  for (const double limit : {0.05, 0.02}) {
    const auto resampled = resample(mesh, {limit, uint64_t{1} << 30});
    ASSERT_TRUE(resampled) << resampled.error().message;
    EXPECT_EQ(resampled->max_error, limit);
    const ResampleError reported = measure_error(mesh, *resampled);
    EXPECT_LT(reported.above, 0.01);
    std::mt19937 random(3);
    double most = 0, squares = 0;
    for (int32_t i = 0; i < 2000; ++i) {
      const Vec3d at = random_point(random, kUnit);
      const auto expected = brute_value(mesh, at), found = value_at(*resampled, at);
      ASSERT_TRUE(expected && found);
      most = std::max(most, std::abs(*expected - *found));
      squares += (*expected - *found) * (*expected - *found) / 2000;
    }
    EXPECT_LT(most, 1.5 * limit);
    EXPECT_LT(most, 1.3 * reported.max);
    EXPECT_NEAR(std::sqrt(squares), reported.rms, 0.2 * reported.rms);
  }
}

TEST(Unstructured, LeavesAreNoLargerThanTheCellsOfTheMesh) {
  UnstructuredMesh mesh;
  add_block(mesh, {{0, 0, 0}, {4, 1, 1}}, {32, 8, 8}, Division::hexahedra, [](Vec3d p) {
    return Vec3d{p.x * p.x / 4, p.y, p.z};
  });
  set_values(mesh, linear);
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled);
  const AdaptiveGrid& grid = resampled->grid;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    const CellGeometry geometry = mesh.geometry(cell);
    const Box box = box_of(geometry);
    const Vec3d at = (box.low + box.high) * 0.5 - resampled->level_0.origin;
    for (uint32_t level = 0; level < grid.levels(); ++level) {
      const Vec3d edges = resampled->level_0.spacing * (1.0 / grid.cells_per_edge(0, level));
      const Index3 index{static_cast<int32_t>(at.x / edges.x), static_cast<int32_t>(at.y / edges.y),
                         static_cast<int32_t>(at.z / edges.z)};
      if (grid.bricks(level).state(index) != CellState::leaf) continue;
      EXPECT_LE(std::max({edges.x, edges.y, edges.z}), 1.01 * size_of(geometry));
    }
  }
}

TEST(Unstructured, GapsStayEmpty) {
  for (const double gap : {0.003, 0.03, 0.1}) {
    UnstructuredMesh mesh;
    // Two oblique blocks, and a gap between them that is thinner than a cell.
    const auto turned = [](Vec3d p) {
      return Vec3d{0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y, p.z};
    };
    add_block(mesh, kUnit, {4, 4, 4}, Division::hexahedra, turned);
    add_block(mesh, {{1 + gap, 0, 0}, {2 + gap, 1, 1}}, {4, 4, 4}, Division::hexahedra, turned);
    set_values(mesh, linear);
    const auto resampled = resample(mesh, {});
    ASSERT_TRUE(resampled) << resampled.error().message;
    std::mt19937 random(4);
    for (int32_t i = 0; i < 2000; ++i) {
      const Vec3d in_gap =
          random_point(random, {{1 + gap * 0.45, 0.1, 0.1}, {1 + gap * 0.55, 0.9, 0.9}});
      ASSERT_FALSE(value_at(*resampled, turned(in_gap))) << "gap " << gap;
      EXPECT_TRUE(
          value_at(*resampled, turned(random_point(random, {{0.1, 0.1, 0.1}, {0.9, 0.9, 0.9}}))));
    }
    EXPECT_LT(measure_error(mesh, *resampled).outside, 0.08);
  }
}

TEST(Unstructured, BlocksThatTouchHaveNoGap) {
  UnstructuredMesh mesh;
  const auto turned = [](Vec3d p) {
    return Vec3d{0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y, p.z};
  };
  // The second block has points of its own, the third one other faces.
  add_block(mesh, kUnit, {4, 4, 4}, Division::hexahedra, turned);
  add_block(mesh, {{1, 0, 0}, {2, 1, 1}}, {4, 4, 4}, Division::hexahedra, turned);
  add_block(mesh, {{2, 0, 0}, {3, 1, 1}}, {6, 6, 6}, Division::tetrahedra, turned);
  set_values(mesh, linear);
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled);
  std::mt19937 random(5);
  for (int32_t i = 0; i < 3000; ++i) {
    const auto value =
        value_at(*resampled, turned(random_point(random, {{0.1, 0.1, 0.1}, {2.9, 0.9, 0.9}})));
    ASSERT_TRUE(value);
  }
}

TEST(Unstructured, TheBorderIsRightOnAverage) {
  UnstructuredMesh mesh;  // a ball
  add_block(mesh, {{-1, -1, -1}, {1, 1, 1}}, {8, 8, 8}, Division::hexahedra, [](Vec3d p) {
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    return largest > 0 ? p * (largest / length(p)) : p;
  });
  set_values(mesh, linear);
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled) << resampled.error().message;
  double volume = 0, expected = 0, beyond = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) expected += volume_of(mesh.geometry(cell));
  const AdaptiveGrid& grid = resampled->grid;
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    const Vec3d edges = resampled->level_0.spacing * (1.0 / grid.cells_per_edge(0, level));
    for (const auto& [key, brick] : grid.bricks(level)) {
      for (size_t i = 0; i < kBrickVolume; ++i) {
        if (brick.states[i] != CellState::leaf) continue;
        volume += edges.x * edges.y * edges.z;
        const Index3 cell = cell_of(brick, i);
        const Vec3d centre =
            resampled->level_0.origin +
            Vec3d{(cell.x + 0.5) * edges.x, (cell.y + 0.5) * edges.y, (cell.z + 0.5) * edges.z};
        beyond = std::max(beyond, length(centre));
      }
    }
  }
  EXPECT_NEAR(volume / expected, 1, 0.01);
  EXPECT_LT(beyond, 1.02);
  EXPECT_FALSE(value_at(*resampled, {0.8, 0.8, 0}));
}

TEST(Unstructured, CellsWithoutValuesAreHoles) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {4, 4, 4}, Division::hexahedra);
  set_values(mesh, [](Vec3d p) { return p.x > 0.7 ? std::nan("") : linear(p); });
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled);
  EXPECT_TRUE(value_at(*resampled, {0.4, 0.5, 0.5}));
  EXPECT_FALSE(value_at(*resampled, {0.6, 0.5, 0.5}));
}

TEST(Unstructured, ValuesOfCellsAreWeightedByVolume) {
  UnstructuredMesh mesh;
  add_block(mesh, {{0, 0, 0}, {3, 1, 1}}, {2, 1, 1}, Division::hexahedra, [](Vec3d p) {
    return p.x == 1.5 ? Vec3d{1, p.y, p.z} : p;
  });
  const auto values = values_at_points(mesh, std::vector<double>{3, 6});
  EXPECT_DOUBLE_EQ(values[0], 3);
  EXPECT_DOUBLE_EQ(values[1], (1 * 3.0 + 2 * 6.0) / 3);
  EXPECT_DOUBLE_EQ(values[2], 6);
}

TEST(Unstructured, RefusesWhatDoesNotFit) {
  UnstructuredMesh mesh;
  const auto status = [&](uint64_t bytes) {
    const auto resampled = resample(mesh, {0, bytes});
    return resampled ? Status::ok : resampled.error().status;
  };
  EXPECT_EQ(status(1 << 20), Status::malformed_volume);
  // Flat cells alone.
  add_block(mesh, {{0, 0, 0}, {1, 1, 0}}, {2, 2, 2}, Division::hexahedra);
  set_values(mesh, linear);
  EXPECT_EQ(status(1 << 20), Status::malformed_volume);
  mesh = {};
  add_block(mesh, kUnit, {20, 20, 20}, Division::tetrahedra);
  set_values(mesh, waves);
  for (const uint64_t bytes : {1000, 100'000, 1'000'000}) {
    EXPECT_EQ(status(bytes), Status::out_of_memory) << bytes;
  }
  EXPECT_EQ(status(8'000'000), Status::ok);
}

}  // namespace
}  // namespace isosplat::mesh_test
