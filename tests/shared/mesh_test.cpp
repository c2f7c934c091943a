// Triangles. Compares each cell with the trilinear function on a fine lattice, and checks that
// whole volumes have closed surfaces.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <queue>
#include <set>
#include <unordered_map>

#include "shared/core/mesh/block_mesh.h"
#include "shared/core/mesh/cell_surface.h"
#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

using Triangle = std::array<uint32_t, 3>;
using Values = std::array<double, 8>;

/// Vertices − edges + triangles.
int euler_number(const std::vector<Triangle>& triangles) {
  std::set<uint32_t> vertices;
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (const Triangle& t : triangles) {
    for (size_t i = 0; i < 3; ++i) {
      vertices.insert(t[i]);
      edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    }
  }
  return int(vertices.size()) - int(edges.size()) + int(triangles.size());
}

/// The directed edges that no triangle has in the other direction. Fails if two triangles have one
/// edge in the same direction.
std::vector<std::pair<uint32_t, uint32_t>> open_edges(const std::vector<Triangle>& triangles) {
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (const Triangle& t : triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const bool is_new = edges.insert({t[i], t[(i + 1) % 3]}).second;
      EXPECT_TRUE(is_new) << "more than two triangles at an edge";
    }
  }
  std::vector<std::pair<uint32_t, uint32_t>> open;
  for (const auto& [a, b] : edges) {
    if (!edges.contains({b, a})) open.emplace_back(a, b);
  }
  return open;
}

/// Whether the triangles around each vertex form one fan, closed or open.
bool has_single_fans(const std::vector<Triangle>& triangles) {
  std::map<uint32_t, std::vector<std::pair<uint32_t, uint32_t>>> links;
  for (const Triangle& t : triangles) {
    for (size_t i = 0; i < 3; ++i) links[t[i]].emplace_back(t[(i + 1) % 3], t[(i + 2) % 3]);
  }
  for (const auto& [vertex, link] : links) {
    std::map<uint32_t, uint32_t> next(link.begin(), link.end());
    if (next.size() != link.size()) return false;
    std::set<uint32_t> ends;
    for (const auto& [from, to] : next) ends.insert(to);
    uint32_t at = link[0].first;
    for (const auto& [from, to] : next) {
      if (!ends.contains(from)) at = from;
    }
    size_t steps = 0;
    for (; steps < link.size(); ++steps) {
      const auto found = next.find(at);
      if (found == next.end()) break;
      at = found->second;
    }
    if (steps != link.size()) return false;
  }
  return true;
}

double trilinear(const Values& v, double x, double y, double z) {
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    sum += v[size_t(i)] * (i & 1 ? x : 1 - x) * (i & 2 ? y : 1 - y) * (i & 4 ? z : 1 - z);
  }
  return sum;
}

/// The number of connected parts of a cell above and not above 0, on a lattice of n³ points.
int lattice_parts(const Values& v, int n) {
  std::vector<int8_t> state(size_t(n) * size_t(n) * size_t(n));
  const auto index = [n](int x, int y, int z) {
    return (size_t(z) * size_t(n) + size_t(y)) * size_t(n) + size_t(x);
  };
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const double s = n - 1;
        state[index(x, y, z)] = trilinear(v, x / s, y / s, z / s) > 0 ? 1 : 0;
      }
    }
  }
  int parts = 0;
  std::vector<std::array<int, 3>> stack;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const int8_t side = state[index(x, y, z)];
        if (side < 0) continue;
        ++parts;
        stack.push_back({x, y, z});
        state[index(x, y, z)] = -1;
        while (!stack.empty()) {
          const auto at = stack.back();
          stack.pop_back();
          for (size_t axis = 0; axis < 3; ++axis) {
            for (const int step : {-1, 1}) {
              auto to = at;
              to[axis] += step;
              if (to[axis] < 0 || to[axis] >= n) continue;
              int8_t& found = state[index(to[0], to[1], to[2])];
              if (found != side) continue;
              found = -1;
              stack.push_back(to);
            }
          }
        }
      }
    }
  }
  return parts;
}

std::vector<Triangle> triangles_of(const CellTriangles& surface) {
  std::vector<Triangle> result;
  for (const CellTriangle& t : surface.triangles) result.push_back({t[0], t[1], t[2]});
  return result;
}

/// The number of loops that the open edges form.
int loop_count(const std::vector<std::pair<uint32_t, uint32_t>>& open) {
  std::map<uint32_t, uint32_t> next(open.begin(), open.end());
  EXPECT_EQ(next.size(), open.size());
  int loops = 0;
  while (!next.empty()) {
    ++loops;
    for (auto at = next.begin(); at != next.end();) {
      const uint32_t to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  return loops;
}

TEST(CellSurface, HasTheTopologyOfTheTrilinearFunction) {
  RandomCells random(7);
  int tunnels = 0, tested = 0;
  std::map<int, int> by_loops;
  for (int run = 0; run < 40'000; ++run) {
    Values values;
    // All eight signs are equally likely, which makes ambiguous cells frequent.
    for (double& v : values) v = (random.unit() + 0.01) * (random.integer(2) ? 1 : -1);
    const auto triangles = triangles_of(cell_surface(values));
    if (triangles.empty()) continue;
    const auto open = open_edges(triangles);
    for (const auto& [a, b] : open) {
      ASSERT_NE(faces_of_edge(int(a)) & faces_of_edge(int(b)), 0u) << "an open edge inside";
    }
    ASSERT_TRUE(has_single_fans(triangles));
    const int loops = loop_count(open);
    const int euler = euler_number(triangles);
    ASSERT_TRUE(euler == loops || euler == loops - 2) << euler << " " << loops;
    ++by_loops[loops];
    if (loops < 2) continue;
    tunnels += euler != loops;
    if (tested >= 1000) continue;
    // Surfaces separate the cell: without a tunnel there is one part more than loops.
    const int parts = lattice_parts(values, 20);
    if (parts != lattice_parts(values, 33)) continue;
    ++tested;
    EXPECT_EQ(euler == loops ? loops + 1 : loops, parts);
  }
  EXPECT_GT(tunnels, 50);
  EXPECT_GT(tested, 900);
  for (const int loops : {1, 2, 3, 4}) EXPECT_GT(by_loops[loops], 0) << loops;
}

/// A volume, cut into blocks of any size, and its mesh.
struct Scene {
  Index3 voxels;
  std::function<double(int, int, int)> value;

  CellCorners corners(Index3 cell) const {
    CellCorners result;
    for (int i = 0; i < 8; ++i) {
      const double v = value(cell.x + (i & 1), cell.y + (i >> 1 & 1), cell.z + (i >> 2));
      result[size_t(i)] = static_cast<QuantizedValue>(v);
    }
    return result;
  }
};

struct Mesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  std::vector<Vec3f> gradients;
};

/// Meshes blocks one after the other and merges the vertices of their borders.
Mesh mesh_of(const Scene& scene, int32_t block, float isovalue) {
  Mesh result;
  BlockMesher mesher;
  std::unordered_map<uint64_t, uint32_t> border;
  const Index3 n{scene.voxels.x - 1, scene.voxels.y - 1, scene.voxels.z - 1};
  for (int32_t z = 0; z < n.z; z += block) {
    for (int32_t y = 0; y < n.y; y += block) {
      for (int32_t x = 0; x < n.x; x += block) {
        const Index3 size{std::min(block, n.x - x), std::min(block, n.y - y),
                          std::min(block, n.z - z)};
        DecodedCells cells;
        for (int32_t k = 0; k < size.z; ++k) {
          for (int32_t j = 0; j < size.y; ++j) {
            for (int32_t i = 0; i < size.x; ++i) {
              cells.cell.push_back(static_cast<uint32_t>(i | j << 6 | k << 12));
              cells.corners.push_back(scene.corners({x + i, y + j, z + k}));
              cells.interval.push_back(corner_interval(cells.corners.back()));
            }
          }
        }
        BlockMesh mesh;
        mesher.run(cells, size, {x, y, z}, isovalue, mesh);
        std::vector<uint32_t> global(mesh.vertices.size());
        size_t next = 0;
        for (uint32_t v = 0; v < global.size(); ++v) {
          const Vec3f at = mesh.vertices[v].position + Vec3f{float(x), float(y), float(z)};
          global[v] = uint32_t(result.vertices.size());
          if (next < mesh.border.size() && mesh.border[next].vertex == v) {
            const auto [known, is_new] = border.emplace(mesh.border[next++].edge.key(), global[v]);
            global[v] = known->second;
            if (!is_new) {
              EXPECT_LT(length(at - result.vertices[global[v]]), 1e-5);
              result.gradients[global[v]] =
                  result.gradients[global[v]] + mesh.vertices[v].gradient();
              continue;
            }
          }
          result.vertices.push_back(at);
          result.gradients.push_back(mesh.vertices[v].gradient());
        }
        EXPECT_EQ(next, mesh.border.size());
        for (const Triangle& t : mesh.triangles) {
          result.triangles.push_back({global[t[0]], global[t[1]], global[t[2]]});
        }
      }
    }
  }
  return result;
}

double volume_inside(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto at = [&](size_t i) {
      const Vec3f v = mesh.vertices[t[i]];
      return Vec3d{v.x, v.y, v.z};
    };
    sum += dot(at(0), cross(at(1), at(2))) / 6;
  }
  return sum;
}

TEST(BlockMesh, NoiseHasAClosedManifoldSurfaceAcrossBlocks) {
  const Index3 voxels{15, 14, 13};
  RandomCells random(3);
  std::vector<QuantizedValue> noise(size_t(voxels.x) * size_t(voxels.y) * size_t(voxels.z));
  // There are few different values, so that faces with the saddle on the isosurface, and voxels on
  // it, are frequent.
  for (auto& v : noise) v = static_cast<QuantizedValue>(random.integer(6));
  const Scene scene{voxels, [&](int x, int y, int z) -> double {
                      const bool inside = x > 0 && y > 0 && z > 0 && x < voxels.x - 1 &&
                                          y < voxels.y - 1 && z < voxels.z - 1;
                      return inside ? noise[size_t((z * voxels.y + y) * voxels.x + x)] : 0;
                    }};
  for (const float isovalue : {0.5f, 1.0f, 2.5f, 3.0f, 4.25f}) {
    const Mesh whole = mesh_of(scene, 64, isovalue);
    EXPECT_GT(whole.triangles.size(), 1000u);
    EXPECT_TRUE(open_edges(whole.triangles).empty());
    EXPECT_TRUE(has_single_fans(whole.triangles));
    EXPECT_GT(volume_inside(whole), 0);
    for (const int32_t block : {1, 4, 7}) {
      const Mesh parts = mesh_of(scene, block, isovalue);
      EXPECT_EQ(parts.vertices.size(), whole.vertices.size());
      EXPECT_EQ(parts.triangles.size(), whole.triangles.size());
      EXPECT_TRUE(open_edges(parts.triangles).empty());
      EXPECT_TRUE(has_single_fans(parts.triangles));
      EXPECT_NEAR(volume_inside(parts), volume_inside(whole), 1e-2);
    }
  }
}

TEST(BlockMesh, PlatesWithEmptySlicesBetweenThemDoNotShareVertices) {
  const auto plates = [](int first, int last) {
    const Scene scene{{8, 8, 12}, [=](int x, int y, int z) -> double {
                        const bool inside = x > 0 && y > 0 && x < 7 && y < 7;
                        return inside && (z == first || z == last) ? 1000 : 0;
                      }};
    return mesh_of(scene, 64, 400);
  };
  const Mesh one = plates(2, 2), two = plates(2, 8);
  EXPECT_EQ(two.vertices.size(), 2 * one.vertices.size());
  EXPECT_TRUE(open_edges(two.triangles).empty());
  EXPECT_EQ(euler_number(two.triangles), 4);
  EXPECT_NEAR(volume_inside(two), 2 * volume_inside(one), 1e-3);
}

TEST(BlockMesh, ASphereHasItsVolumeAndNormals) {
  const double centre = 19.7, radius = 15.3;
  const auto value = [&](double x, double y, double z) {
    return 40000 - 1000 * std::hypot(x - centre, y - centre, z - centre);
  };
  const Scene scene{{40, 40, 40}, [&](int x, int y, int z) { return value(x, y, z); }};
  const Mesh mesh = mesh_of(scene, 16, float(40000 - 1000 * radius));
  EXPECT_TRUE(open_edges(mesh.triangles).empty());
  EXPECT_EQ(euler_number(mesh.triangles), 2);
  const double exact = 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
  EXPECT_NEAR(volume_inside(mesh), exact, 0.005 * exact);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3f out = mesh.vertices[i] - Vec3f{float(centre), float(centre), float(centre)};
    const Vec3f g = mesh.gradients[i];
    EXPECT_LT(dot(out, g) / (length(out) * length(g)), -std::cos(2.0 * std::numbers::pi / 180));
  }
}

TEST(BlockMesh, ATorusHasOneHole) {
  const Scene scene{{48, 48, 24}, [](int x, int y, int z) {
                      const double r = std::hypot(x - 23.5, y - 23.5) - 14;
                      return 30000 - 1000 * std::hypot(r, z - 11.5);
                    }};
  const Mesh mesh = mesh_of(scene, 16, 30000 - 1000 * 6.5f);
  EXPECT_TRUE(open_edges(mesh.triangles).empty());
  EXPECT_EQ(euler_number(mesh.triangles), 0);
  const double exact = 2 * std::numbers::pi * std::numbers::pi * 14 * 6.5 * 6.5;
  EXPECT_NEAR(volume_inside(mesh), exact, 0.01 * exact);
}

}  // namespace
}  // namespace isosplat
