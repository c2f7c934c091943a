// Tests components and simplification of meshes with spheres.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "native/extract/mesh_components.h"
#include "native/extract/simplify_mesh.h"
#include "shared/core/base/vec3.h"

namespace isosplat {
namespace {

/// Appends a sphere: an octahedron whose triangles are divided in four `steps` times.
void add_sphere(MeshPart& mesh, Vec3d centre, double radius, int steps) {
  std::vector<Vec3d> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<uint32_t, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                 {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int step = 0; step < steps; ++step) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [entry, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                       static_cast<uint32_t>(points.size()));
      if (is_new) {
        const Vec3d sum = points[a] + points[b];
        points.push_back(sum * (1 / length(sum)));
      }
      return entry->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  const auto first = static_cast<uint32_t>(mesh.vertices.positions.size());
  for (const Vec3d& p : points) {
    mesh.vertices.positions.push_back(centre + p * radius);
    mesh.vertices.normals.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  for (const auto& [a, b, c] : triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

/// The number of edges that do not have exactly one triangle on each side.
size_t open_edges(const MeshPart& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> sides;
  for (const auto& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) ++sides[{t[i], t[(i + 1) % 3]}];
  }
  size_t open = 0;
  for (const auto& [edge, count] : sides) {
    const auto other = sides.find({edge.second, edge.first});
    open += count != 1 || other == sides.end() || other->second != 1;
  }
  return open;
}

TEST(MeshComponents, AreKeptByTheirArea) {
  MeshPart mesh;
  add_sphere(mesh, {0, 0, 0}, 1, 3);  // has the most triangles
  add_sphere(mesh, {10, 0, 0}, 3, 1);
  add_sphere(mesh, {20, 0, 0}, 2, 1);
  MeshPart largest = mesh;
  EXPECT_EQ(keep_largest_components(largest, 1), 3u);
  MeshPart expected;
  add_sphere(expected, {10, 0, 0}, 3, 1);
  EXPECT_EQ(largest.triangles, expected.triangles);
  EXPECT_EQ(largest.vertices.positions.size(), expected.vertices.positions.size());
  EXPECT_EQ(largest.vertices.normals.size(), expected.vertices.normals.size());
  EXPECT_EQ(largest.vertices.positions[3].y, -3);
  MeshPart two = mesh;
  EXPECT_EQ(keep_largest_components(two, 2), 3u);
  EXPECT_EQ(two.triangles.size(), 64u);
  EXPECT_EQ(open_edges(two), 0u);
  MeshPart all = mesh;
  EXPECT_EQ(keep_largest_components(all, 5), 3u);
  EXPECT_EQ(all.triangles, mesh.triangles);
}

TEST(MeshComponents, TheFirstOfEqualAreaIsKept) {
  MeshPart mesh;
  add_sphere(mesh, {0, 0, 0}, 1, 1);
  add_sphere(mesh, {4, 0, 0}, 1, 1);
  keep_largest_components(mesh, 1);
  EXPECT_EQ(mesh.vertices.positions[0].x, 1);
}

TEST(MeshComponents, WithAreasThatAreNotNumbersComeLast) {
  MeshPart mesh;
  for (int i = 0; i < 40; ++i) add_sphere(mesh, {4.0 * i, 0, 0}, i % 2 ? 1e200 : 1, 0);
  EXPECT_EQ(keep_largest_components(mesh, 1), 40u);
  EXPECT_EQ(mesh.triangles.size(), 8u);
}

TEST(MeshComponents, AnEmptyMeshHasNone) {
  MeshPart mesh;
  EXPECT_EQ(keep_largest_components(mesh, 1), 0u);
}

TEST(SimplifyMesh, StaysCloseAndClosed) {
  const Vec3d centre{1e6, -2e6, 5};  // where single precision steps by 1/8
  MeshPart mesh;
  add_sphere(mesh, centre, 10, 6);
  const size_t before = mesh.triangles.size();
  const double allowed = 0.02;
  const auto error = simplify_mesh(mesh, allowed);
  ASSERT_TRUE(error);
  EXPECT_GT(*error, 0);
  EXPECT_LE(*error, allowed);
  EXPECT_LT(mesh.triangles.size(), before / 5);
  EXPECT_EQ(open_edges(mesh), 0u);
  EXPECT_EQ(mesh.vertices.positions.size(), mesh.triangles.size() / 2 + 2);  // Euler: a sphere
  // Vertices are still on the sphere, and have its normals. The middles of triangles are below the
  // sphere.
  double deepest = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& at = mesh.vertices.positions;
    deepest = std::max(deepest, 10 - length((at[a] + at[b] + at[c]) * (1.0 / 3) - centre));
  }
  EXPECT_LT(deepest, 4 * allowed);
  for (size_t i = 0; i < mesh.vertices.positions.size(); ++i) {
    const Vec3d out = (mesh.vertices.positions[i] - centre) * 0.1;
    const Vec3f n = mesh.vertices.normals[i];
    EXPECT_NEAR(length(out), 1, 1e-6);
    EXPECT_NEAR(dot(out, Vec3d{n.x, n.y, n.z}), 1, 1e-6);
  }
}

TEST(SimplifyMesh, LeavesAnEmptyMesh) {
  MeshPart mesh;
  const auto error = simplify_mesh(mesh, 1);
  ASSERT_TRUE(error);
  EXPECT_EQ(*error, 0);
}

}  // namespace
}  // namespace isosplat
