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

/// A hexahedron that is flat: its upper corners are its lower ones.
void add_flat_cell(UnstructuredMesh& mesh, std::array<uint32_t, 4> p) {
  add_cell(mesh, CellShape::hexahedron, {p[0], p[1], p[2], p[3], p[0], p[1], p[2], p[3]});
}

/// A face that is shared has a cell with a volume on its other side.
TEST(UnstructuredHoles, RepeatedAndFlatCellsCloseNoGaps) {
  const auto turned = [](Vec3d p) {
    return Vec3d{0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y, p.z};
  };
  const double gap = 0.03;
  for (const bool are_flat : {false, true}) {
    UnstructuredMesh mesh;
    add_block(mesh, {{0, 0, 0}, {1, 1, 1}}, {4, 4, 4}, Division::hexahedra, turned);
    add_block(mesh, {{1 + gap, 0, 0}, {2 + gap, 1, 1}}, {4, 4, 4}, Division::hexahedra, turned);
    const size_t cells = mesh.cells();
    for (size_t cell = 0; cell < cells; ++cell) {
      const auto p = mesh.corners_of(cell);
      const std::vector<uint32_t> corners(p.begin(), p.end());
      if (!are_flat) {
        add_cell(mesh, CellShape::hexahedron, corners);
        continue;
      }
      for (const CellFace& face : faces_of(CellShape::hexahedron)) {
        const auto corner = [&](size_t i) { return corners[static_cast<size_t>(face[i])]; };
        add_flat_cell(mesh, {corner(0), corner(1), corner(2), corner(3)});
      }
    }
    set_values(mesh, linear);
    const auto resampled = resample(mesh, {});
    ASSERT_TRUE(resampled) << resampled.error().message;
    int32_t filled = 0, empty = 0;
    for (int32_t i = 0; i < 1000; ++i) {
      const double y = 0.1 + 0.8 * (i % 40) / 40, z = 0.1 + 0.8 * (i / 40) / 25;
      filled += value_at(*resampled, turned({1 + gap / 2, y, z})).has_value();
      empty += !value_at(*resampled, turned({0.1 + 0.8 * y, y, z}));
    }
    EXPECT_EQ(filled, 0) << are_flat;
    EXPECT_EQ(empty, 0) << are_flat;
  }
}

/// What resample() leaves out is no part of the measured error.
TEST(UnstructuredHoles, CellsThatAreLeftOutHaveNoError) {
  UnstructuredMesh mesh;
  add_block(mesh, kThree, {3, 3, 3}, Division::hexahedra);
  std::array<uint32_t, 4> flat{};
  const Vec3d square[] = {{1, 1, 1.5}, {2, 1, 1.5}, {2, 2, 1.5}, {1, 2, 1.5}};
  for (size_t i = 0; i < 4; ++i) flat[i] = add_point(mesh, square[i]);
  add_flat_cell(mesh, flat);
  add_block(mesh, {{1e39, 0, 0}, {2e39, 1e39, 1e39}}, {1, 1, 1}, Division::hexahedra);
  set_values(mesh, linear);
  for (const uint32_t point : flat) mesh.values[point] = 1e6;
  const auto resampled = resample(mesh, {});
  ASSERT_TRUE(resampled) << resampled.error().message;
  const ResampleError error = measure_error(mesh, *resampled);
  EXPECT_EQ(error.outside, 0);
  EXPECT_LT(error.max, 1e-9);
  EXPECT_GT(error.points, 0u);
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
