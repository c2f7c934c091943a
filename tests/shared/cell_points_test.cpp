#include "shared/core/unstructured/cell_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/shared/mesh_fixture.h"

namespace isosplat {
namespace {

using mesh_test::add_block;
using mesh_test::Division;

constexpr Box kUnit{{0, 0, 0}, {1, 1, 1}};

/// Moves inner points, so that cells are not boxes.
Vec3d bent(Vec3d p) {
  const double bend =
      0.08 * std::sin(3.1416 * p.x) * std::sin(3.1416 * p.y) * std::sin(3.1416 * p.z);
  return {1000 + p.x + bend, p.y - bend, p.z + 0.7 * bend};
}

/// Compares with the definition: the cells that have values on both sides. Calls `check` with each
/// point, its cell and its value.
template <class Check>
size_t expect_active_cells(const UnstructuredMesh& mesh, double isovalue, const Check& check) {
  size_t active = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    double least = 1e300, most = -1e300;
    for (const uint32_t corner : mesh.corners_of(cell)) {
      least = std::min(least, mesh.values[corner]);
      most = std::max(most, mesh.values[corner]);
    }
    const auto point = point_of_cell(mesh, cell, isovalue);
    EXPECT_EQ(point.has_value(), least <= isovalue && isovalue < most) << cell;
    if (!point) continue;
    ++active;
    EXPECT_NEAR(length(point->normal), 1, 1e-12);
    EXPECT_EQ(point->size, mesh.size(cell));
    const auto weights = weights_in_cell(mesh.geometry(cell), point->position);
    EXPECT_TRUE(weights) << cell;
    if (weights) check(*point, mesh.value(cell, *weights), most - least);
  }
  return active;
}

class CellPoints : public ::testing::TestWithParam<Division> {};

TEST_P(CellPoints, LinearFunctionsAreExact) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {5, 4, 6}, GetParam(), bent);
  const Vec3d slope{2, -1, 0.5};
  mesh_test::set_values(mesh, [&](Vec3d p) { return dot(slope, p - Vec3d{1000, 0, 0}); });
  const Vec3d down = slope * (-1 / length(slope));
  const size_t active =
      expect_active_cells(mesh, 0.6, [&](const CellPoint& point, double value, double range) {
        ASSERT_LT(length(point.normal - down), 1e-6);
        ASSERT_NEAR(value, 0.6, 1e-8 * range);
      });
  EXPECT_GT(active, 40u);
}

TEST_P(CellPoints, LieOnSpheresAndPointAwayFromGreaterValues) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {12, 12, 12}, GetParam(), bent);
  const Vec3d centre{1000.5, 0.45, 0.5};
  mesh_test::set_values(mesh, [&](Vec3d p) { return -length(p - centre); });
  double squares = 0;
  const size_t active =
      expect_active_cells(mesh, -0.35, [&](const CellPoint& point, double, double) {
        const Vec3d from = point.position - centre;
        const double off = length(from) - 0.35;
        squares += off * off;
        ASSERT_GT(dot(point.normal, from) / length(from), 0.7);
      });
  EXPECT_GT(active, 300u);
  // A twentieth of the edge of a box.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(active)), 0.05 / 12);
}

INSTANTIATE_TEST_SUITE_P(Shapes, CellPoints,
                         ::testing::Values(Division::hexahedra, Division::tetrahedra,
                                           Division::wedges, Division::pyramids, Division::mixed));

TEST(CellPointsAlone, CellsThatAreLeftOutHaveNone) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {2, 1, 1}, Division::hexahedra);
  mesh_test::set_values(mesh, [](Vec3d p) { return p.x; });
  EXPECT_TRUE(point_of_cell(mesh, 0, 0.25));
  EXPECT_FALSE(point_of_cell(mesh, 1, 0.25));
  // A corner without a value, and a flat cell.
  UnstructuredMesh missing = mesh;
  missing.values[0] = std::nan("");
  EXPECT_FALSE(point_of_cell(missing, 0, 0.25));
  for (Vec3d& point : mesh.points) point.z = 0;
  EXPECT_FALSE(point_of_cell(mesh, 0, 0.25));
}

}  // namespace
}  // namespace isosplat
