#pragma once

#include <functional>
#include <random>

#include "shared/core/unstructured/mesh.h"

// Generated unstructured meshes.
namespace isosplat::mesh_test {

inline void add_cell(UnstructuredMesh& mesh, CellShape shape,
                     const std::vector<uint32_t>& corners) {
  mesh.shapes.push_back(shape);
  mesh.begins.push_back(static_cast<uint32_t>(mesh.corners.size()));
  mesh.corners.insert(mesh.corners.end(), corners.begin(), corners.end());
}

inline uint32_t add_point(UnstructuredMesh& mesh, Vec3d at) {
  mesh.points.push_back(at);
  return static_cast<uint32_t>(mesh.points.size() - 1);
}

inline void set_values(UnstructuredMesh& mesh, const std::function<double(Vec3d)>& field) {
  mesh.values.clear();
  for (const Vec3d at : mesh.points) mesh.values.push_back(field(at));
}

/// How boxes are divided into cells.
enum class Division { hexahedra, tetrahedra, wedges, pyramids, mixed };

/// Adds cells³ boxes between two corners, divided. `place` moves the points.
inline void add_block(
    UnstructuredMesh& mesh, Box box, Index3 cells, Division division,
    const std::function<Vec3d(Vec3d)>& place = [](Vec3d p) { return p; }) {
  const auto first = static_cast<uint32_t>(mesh.points.size());
  const Index3 n = cells + Index3{1, 1, 1};
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const Vec3d size = box.high - box.low;
        add_point(mesh, place(box.low + Vec3d{size.x * x / cells.x, size.y * y / cells.y,
                                              size.z * z / cells.z}));
      }
    }
  }
  const auto point = [&](int32_t x, int32_t y, int32_t z) {
    return first + static_cast<uint32_t>((z * n.y + y) * n.x + x);
  };
  int32_t number = 0;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      for (int32_t x = 0; x < cells.x; ++x, ++number) {
        const std::array<uint32_t, 8> p{point(x, y, z),
                                        point(x + 1, y, z),
                                        point(x + 1, y + 1, z),
                                        point(x, y + 1, z),
                                        point(x, y, z + 1),
                                        point(x + 1, y, z + 1),
                                        point(x + 1, y + 1, z + 1),
                                        point(x, y + 1, z + 1)};
        switch (division == Division::mixed ? static_cast<Division>(number % 4) : division) {
          case Division::tetrahedra:  // Kuhn's: around the diagonal 0–6
            for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}}) {
              add_cell(mesh, CellShape::tetrahedron,
                       {p[0], p[static_cast<size_t>(a)], p[static_cast<size_t>(b)], p[6]});
            }
            break;
          case Division::wedges:
            add_cell(mesh, CellShape::wedge, {p[0], p[1], p[2], p[4], p[5], p[6]});
            add_cell(mesh, CellShape::wedge, {p[0], p[2], p[3], p[4], p[6], p[7]});
            break;
          case Division::pyramids: {
            Vec3d centre{0, 0, 0};
            for (const uint32_t each : p) centre = centre + mesh.points[each] * 0.125;
            const uint32_t apex = add_point(mesh, centre);
            for (const CellFace& face : faces_of(CellShape::hexahedron)) {
              std::vector<uint32_t> corners;
              for (const int8_t corner : face) corners.push_back(p[static_cast<size_t>(corner)]);
              corners.push_back(apex);
              add_cell(mesh, CellShape::pyramid, corners);
            }
            break;
          }
          case Division::hexahedra:
          case Division::mixed:
            add_cell(mesh, CellShape::hexahedron, {p.begin(), p.end()});
        }
      }
    }
  }
}

}  // namespace isosplat::mesh_test
