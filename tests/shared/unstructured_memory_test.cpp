// The memory of resampling meshes: less of it has the same result, or one clear error.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shared/core/unstructured/boundary_faces.h"
#include "shared/core/unstructured/resample.h"
#include "tests/shared/mesh_fixture.h"

namespace isosplat::mesh_test {
namespace {

constexpr Box kUnit{{0, 0, 0}, {1, 1, 1}};

double waves(Vec3d p) {
  return std::sin(4 * p.x) * std::cos(3 * p.y) + p.z * p.z;
}

/// Compares the leaf cells and their values, which are to be the same bits.
void expect_same(const AdaptiveGrid& a, const AdaptiveGrid& b) {
  ASSERT_EQ(a.levels(), b.levels());
  uint64_t leaves = 0, others = 0;
  for (uint32_t level = 0; level < a.levels(); ++level) {
    ASSERT_EQ(a.bricks(level).size(), b.bricks(level).size());
    for (const auto& [key, brick] : a.bricks(level)) {
      for (size_t i = 0; i < kBrickVolume; ++i) {
        const Index3 cell = cell_of(brick, i);
        others += brick.states[i] == b.bricks(level).state(cell) ? 0 : 1;
        if (brick.states[i] != CellState::leaf) continue;
        ++leaves;
        for (int32_t k = 0; k < 8; ++k) {
          const Index3 node = cell + Index3{k & 1, k >> 1 & 1, k >> 2};
          others += a.node_value(level, node) == b.node_value(level, node) ? 0 : 1;
        }
      }
    }
  }
  EXPECT_EQ(others, 0u);
  EXPECT_GT(leaves, 1000u);
}

TEST(UnstructuredMemory, TheLeastMemoryHasTheSameResult) {
  UnstructuredMesh mesh;
  // Two blocks with a gap between them, and one cell that is as large as a block.
  add_block(mesh, kUnit, {12, 12, 12}, Division::tetrahedra);
  add_block(mesh, {{1.004, 0, 0}, {2, 1, 1}}, {10, 10, 10}, Division::mixed);
  add_block(mesh, {{2, 0, 0}, {3, 1, 1}}, {1, 1, 1}, Division::hexahedra);
  set_values(mesh, waves);
  const auto whole = resample(mesh, {0.02, uint64_t{1} << 30});
  ASSERT_TRUE(whole) << whole.error().message;
  int failures = 0;
  for (uint64_t memory = 1;; memory = memory * 5 / 4 + 1) {
    ASSERT_LT(memory, uint64_t{64} << 20);
    const auto resampled = resample(mesh, {0.02, memory});
    if (resampled) {
      EXPECT_LE(resampled->grid.memory_bytes(), memory);
      expect_same(whole->grid, resampled->grid);
      break;
    }
    ++failures;
    ASSERT_EQ(resampled.error().status, Status::out_of_memory) << resampled.error().message;
    EXPECT_NE(resampled.error().message.find("raise --memory"), std::string::npos)
        << resampled.error().message;
  }
  EXPECT_GT(failures, 20);
}

TEST(UnstructuredMemory, CellsNearOneGridCellCount) {
  UnstructuredMesh mesh;
  // The grid cells of level 0 are as large as the first cell, so all others are near one of them.
  add_block(mesh, {{0, 0, 0}, {8, 8, 8}}, {1, 1, 1}, Division::hexahedra);
  add_block(mesh, {{9, 1, 1}, {11, 3, 3}}, {24, 24, 24}, Division::tetrahedra);
  set_values(mesh, [](Vec3d p) { return p.x; });
  ASSERT_EQ(mesh.cells(), 82'945u);
  const auto resampled = resample(mesh, {0, uint64_t{64} << 20});
  ASSERT_TRUE(resampled) << resampled.error().message;
  EXPECT_LT(measure_error(mesh, *resampled).max, 1e-6);
  // Enough for everything else: for sizes, faces, and the grid.
  const auto refused = resample(mesh, {0, uint64_t{4} << 20});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::out_of_memory);
}

TEST(UnstructuredMemory, BoundaryFacesAreTheSameWithLittleMemory) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {9, 8, 7}, Division::tetrahedra);
  add_block(mesh, {{1, 0, 0}, {2, 1, 1}}, {4, 4, 4}, Division::pyramids);
  set_values(mesh, waves);
  const auto survey = survey_mesh(mesh);
  ASSERT_TRUE(survey);
  const auto ordered = [&](uint64_t memory) {
    const auto faces = boundary_faces(mesh, *survey, memory);
    std::vector<std::pair<uint32_t, int>> pairs;
    if (!faces) return pairs;
    for (const BoundaryFace& face : *faces) pairs.emplace_back(face.cell, face.face);
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  };
  const auto all = ordered(uint64_t{1} << 30);
  // Those of both blocks, but for the common side where two grids of faces meet.
  EXPECT_EQ(all.size(), 2u * 2 * (9 * 8 + 9 * 7 + 8 * 7) - 2 * 8 * 7 + 5 * 16);
  size_t memory = 1;
  while (ordered(memory).empty()) memory = memory * 5 / 4 + 1;
  EXPECT_LT(memory, 1u << 20);
  EXPECT_EQ(ordered(memory), all);
}

}  // namespace
}  // namespace isosplat::mesh_test
