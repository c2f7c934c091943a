#include <cmath>
#include <random>

#include "shared/import/geometry/orientation.h"
#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::pattern;
using test::pattern_voxels;
using test::TempFolder;
using test::write_file;

void expect_orthonormal_right_handed(const std::array<double, 9>& m) {
  for (size_t a = 0; a < 3; ++a) {
    for (size_t b = 0; b < 3; ++b) {
      EXPECT_NEAR(m[a] * m[b] + m[3 + a] * m[3 + b] + m[6 + a] * m[6 + b], a == b ? 1 : 0, 1e-12);
    }
  }
  EXPECT_NEAR(determinant(m), 1, 1e-12);
}

TEST(Orientation, KeepsARightHandedOrthonormalHeader) {
  HeaderGeometry geometry;
  geometry.spacing = {1, 2, 3};
  geometry.origin = {4, 5, 6};
  geometry.direction = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  const auto result = orient({5, 4, 3}, geometry);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->reverse_rows);
  EXPECT_TRUE(result->notes.empty());
  EXPECT_EQ(result->grid.direction, geometry.direction);
  EXPECT_EQ(result->grid.origin, geometry.origin);
  EXPECT_EQ(result->grid.spacing, geometry.spacing);
}

TEST(Orientation, EveryAxisOrderAndSignKeepsThePositionOfEveryVoxel) {
  const TempFolder folder;
  const Index3 n{5, 4, 3};
  const std::array<std::array<int, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  const double spacing[] = {0.5, 2, 3};
  for (const auto& order : orders) {
    for (int signs = 0; signs < 8; ++signs) {
      double column[3][3] = {};
      std::string directions;
      for (int axis = 0; axis < 3; ++axis) {
        column[axis][order[static_cast<size_t>(axis)]] =
            (signs >> axis & 1 ? -1 : 1) * spacing[axis];
        directions += fmt::format("({},{},{}) ", column[axis][0], column[axis][1], column[axis][2]);
      }
      SCOPED_TRACE(directions);
      write_file(
          folder / "v.nrrd",
          test::nrrd_header(n, "short",
                            "space: left-posterior-superior\nspace directions: " + directions +
                                "\nspace origin: (10,20,30)\nendian: little\n"
                                "encoding: raw\n\n") +
              test::bytes_of(pattern_voxels<int16_t>(n)));
      auto volume = open_volume(folder / "v.nrrd", {});
      ASSERT_TRUE(volume) << volume.error().message;
      EXPECT_TRUE(volume->notes.empty());
      const VolumeGrid& grid = volume->source->header().grid;
      expect_orthonormal_right_handed(grid.direction);
      const auto values = test::read_all(*volume->source);

      // Each voxel of the header's grid must be at its position in the header.
      for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
          for (int x = 0; x < n.x; ++x) {
            const double in_header[3] = {double(x), double(y), double(z)};
            Vec3d world{10, 20, 30};
            for (int axis = 0; axis < 3; ++axis) {
              world = world +
                      Vec3d{column[axis][0], column[axis][1], column[axis][2]} * in_header[axis];
            }
            bool found = false;
            for (int j = 0; j < n.y; ++j) {
              if (length(grid.world({double(x), double(j), double(z)}) - world) > 1e-9) continue;
              found = true;
              EXPECT_EQ(values[static_cast<size_t>((z * n.y + j) * n.x + x)], pattern(x, y, z));
            }
            EXPECT_TRUE(found);
          }
        }
      }
    }
  }
}

// Sheared axes of any handedness and length: the grid is right-handed, and each voxel is at its
// position in the header.
TEST(Orientation, ShearedAxesKeepThePositionOfEveryVoxel) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  int reversed = 0, kept = 0;
  for (int i = 0; i < 300; ++i) {
    HeaderGeometry geometry;
    geometry.spacing = {0.5, 2, 3};
    geometry.origin = {10, 20, 30};
    for (double& d : geometry.direction) d = number(random);
    const auto result = orient({5, 4, 3}, geometry);
    ASSERT_TRUE(result);
    const VolumeGrid& grid = result->grid;
    EXPECT_TRUE(is_basis(grid.direction));
    EXPECT_GT(determinant(grid.direction), 0);
    if (!result->notes.empty()) continue;  // nearly in a plane: see below
    ++(result->reverse_rows ? reversed : kept);
    const auto axis = [&](size_t a) {
      return column(geometry.direction, a) * (1 / length(column(geometry.direction, a)));
    };
    for (const Index3 v : {Index3{0, 0, 0}, Index3{4, 0, 0}, Index3{0, 3, 0}, Index3{2, 1, 2}}) {
      const Vec3d in_header =
          geometry.origin + axis(0) * (0.5 * v.x) + axis(1) * (2.0 * v.y) + axis(2) * (3.0 * v.z);
      const int32_t row = result->reverse_rows ? 3 - v.y : v.y;
      EXPECT_LT(length(grid.world({double(v.x), double(row), double(v.z)}) - in_header), 1e-12);
    }
  }
  EXPECT_GT(reversed, 100);
  EXPECT_GT(kept, 100);
}

TEST(Orientation, InvalidGeometryIsReplacedAndNoted) {
  HeaderGeometry geometry;
  geometry.spacing = {0, std::nan(""), -1};
  geometry.origin = {std::nan(""), 0, 0};
  geometry.direction = {1, 2, 0, 1, 2, 0, 0, 0, 0};
  const auto result = orient({5, 4, 3}, geometry);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->grid.spacing, (Vec3d{1, 1, 1}));
  EXPECT_EQ(result->grid.origin, (Vec3d{0, 0, 0}));
  expect_orthonormal_right_handed(result->grid.direction);
  EXPECT_EQ(result->notes.size(), 5u);
}

TEST(Orientation, RefusesVolumesWithoutCellsAndTooLargeOnes) {
  EXPECT_EQ(orient({1, 4, 3}, {}).error().status, Status::no_cells);
  EXPECT_EQ(orient({5, 4, 0}, {}).error().status, Status::malformed_volume);
  EXPECT_EQ(orient({5, -4, 3}, {}).error().status, Status::malformed_volume);
  EXPECT_EQ(orient({kMaxVoxelsPerAxis + 1, 4, 3}, {}).error().status, Status::volume_too_large);
}

}  // namespace
}  // namespace isosplat::import
