// Unstructured meshes with holes, and with cells that are repeated, flat or huge.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shared/core/unstructured/resample.h"
#include "tests/shared/mesh_fixture.h"

namespace isosplat::mesh_test {
namespace {

constexpr Box kThree{{0, 0, 0}, {3, 3, 3}};

double linear(Vec3d p) {
  return 3 * p.x - 2 * p.y + p.z + 5;
}

/// Removes cells by the position of their centre.
void remove_cells(UnstructuredMesh& mesh, const std::function<bool(Vec3d)>& is_removed) {
  UnstructuredMesh kept;
  kept.points = mesh.points;
  kept.values = mesh.values;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    const Box box = box_of(mesh.geometry(cell));
    if (is_removed((box.low + box.high) * 0.5)) continue;
    const auto corners = mesh.corners_of(cell);
    add_cell(kept, mesh.shapes[cell], {corners.begin(), corners.end()});
  }
  mesh = kept;
}

uint64_t leaf_cells(const AdaptiveGrid& grid) {
  uint64_t leaves = 0;
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    for (const auto& [key, brick] : grid.bricks(level)) {
      leaves += static_cast<uint64_t>(
          std::count(brick.states.begin(), brick.states.end(), CellState::leaf));
    }
  }
  return leaves;
}

/// All corners of the grid cell in the hole lie on cells of the mesh.
TEST(UnstructuredHoles, HolesOfOneCellStayEmpty) {
  const std::function<bool(Vec3d)> holes[] = {
      [](Vec3d p) {
        return length(p - Vec3d{1.5, 1.5, 1.5}) < 0.1;
      },                                                               // one cell
      [](Vec3d p) { return std::hypot(p.x - 1.5, p.y - 1.5) < 0.1; },  // a tunnel
      [](Vec3d p) { return std::abs(p.x - 1.5) < 0.1 && p.y < 2; },    // a slot
      [](Vec3d p) { return std::abs(p.x - 1.5) < 0.1; },               // two plates
  };
  for (const Division division : {Division::hexahedra, Division::wedges}) {
    for (const auto& is_hole : holes) {
      UnstructuredMesh mesh;
      add_block(mesh, kThree, {3, 3, 3}, division);
      set_values(mesh, linear);
      remove_cells(mesh, is_hole);
      const auto resampled = resample(mesh, {});
      ASSERT_TRUE(resampled) << resampled.error().message;
      for (int32_t i = 0; i < 27 * 64; ++i) {
        const Vec3d box{i / 64 % 3 * 1.0, i / 64 / 3 % 3 * 1.0, i / 64 / 9 * 1.0};
        const Vec3d in_box{(i % 4 + 0.5) / 4, (i / 4 % 4 + 0.5) / 4, (i / 16 % 4 + 0.5) / 4};
        const bool is_empty = is_hole(box + Vec3d{0.5, 0.5, 0.5});
        const auto value = value_at(*resampled, box + in_box);
        ASSERT_EQ(value.has_value(), !is_empty) << i;
        if (value) {
          EXPECT_NEAR(*value, linear(box + in_box), 1e-6);
        }
      }
      EXPECT_EQ(measure_error(mesh, *resampled).outside, 0);
    }
  }
}

/// The volume of such a cell divided by the number of cells is 0.
TEST(UnstructuredHoles, CellsThinnerThanNumbersCanDivideAreNoEndlessLoop) {
  UnstructuredMesh mesh;
  add_block(mesh, {{0, 0, 0}, {1, 3e-162, 3e-162}}, {1, 1, 1}, Division::hexahedra);
  for (int32_t i = 0; i < 3; ++i) {
    const auto corners = mesh.corners_of(0);
    add_cell(mesh, CellShape::hexahedron, {corners.begin(), corners.end()});
  }
  set_values(mesh, linear);
  ASSERT_GT(volume_of(mesh.geometry(0)), 0);
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled) << resampled.error().message;
}

TEST(UnstructuredHoles, ConstantFieldsAreNotRefined) {
  for (const double value : {0.0, 0.1, -1013.25, 1e-7, 1e30}) {
    UnstructuredMesh mesh;
    add_block(mesh, kThree, {5, 5, 5}, Division::hexahedra, [](Vec3d p) {
      return Vec3d{p.x * p.x, p.y, p.z};
    });
    set_values(mesh, [](Vec3d p) { return p.x; });
    const auto linear_grid = resample(mesh, {});
    ASSERT_TRUE(linear_grid);
    set_values(mesh, [&](Vec3d) { return value; });
    const auto resampled = resample(mesh, {});
    ASSERT_TRUE(resampled) << resampled.error().message;
    EXPECT_EQ(leaf_cells(resampled->grid), leaf_cells(linear_grid->grid)) << value;
    EXPECT_GE(resampled->max_error, 1e-12 * std::abs(value));
  }
}

}  // namespace
}  // namespace isosplat::mesh_test
