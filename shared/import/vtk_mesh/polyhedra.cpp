#include "shared/import/vtk_mesh/polyhedra.h"

#include <algorithm>

namespace isosplat::import {
namespace {

/// Calls visit(corners) for each face.
template <class Visit>
void for_each_face(FaceStream faces, const Visit& visit) {
  for (size_t at = 0; at < faces.size(); at += size_t{faces[at]} + 1) {
    visit(faces.subspan(at + 1, faces[at]));
  }
}

}  // namespace

std::vector<uint32_t> prism_faces(std::span<const uint32_t> corners) {
  const size_t n = corners.size() / 2;
  std::vector<uint32_t> faces;
  for (const size_t first : {size_t{0}, n}) {
    faces.push_back(static_cast<uint32_t>(n));
    faces.insert(faces.end(), corners.begin() + static_cast<std::ptrdiff_t>(first),
                 corners.begin() + static_cast<std::ptrdiff_t>(first + n));
  }
  for (size_t i = 0; i < n; ++i) {
    const size_t next = (i + 1) % n;
    faces.insert(faces.end(), {4, corners[i], corners[next], corners[n + next], corners[n + i]});
  }
  return faces;
}

size_t add_polyhedron(MeshBuilder& builder, FaceStream faces) {
  std::vector<uint32_t> corners;
  for_each_face(faces, [&](std::span<const uint32_t> face) {
    corners.insert(corners.end(), face.begin(), face.end());
  });
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const uint32_t centre = builder.add_point(corners, {});
  size_t parts = 0;
  for_each_face(faces, [&](std::span<const uint32_t> face) {
    if (face.size() == 3) {
      builder.add_cell(CellShape::tetrahedron, std::array{face[0], face[1], face[2], centre});
      ++parts;
    } else if (face.size() == 4) {
      builder.add_cell(CellShape::pyramid, std::array{face[0], face[1], face[2], face[3], centre});
      ++parts;
    } else {
      const uint32_t middle = builder.add_point(face, {});
      for (size_t i = 0; i < face.size(); ++i) {
        builder.add_cell(CellShape::tetrahedron,
                         std::array{face[i], face[(i + 1) % face.size()], middle, centre});
      }
      parts += face.size();
    }
  });
  return parts;
}

uint64_t polyhedron_bytes(uint64_t stream) {
  // At most a tetrahedron for each corner, a point for every five, and the nodes of all points.
  constexpr uint64_t kPart = sizeof(CellShape) + 2 * sizeof(uint32_t) + 4 * sizeof(uint32_t);
  return stream * kPart + (stream / 5 + 1) * MeshBuilder::point_bytes(0) +
         2 * stream * sizeof(uint32_t);
}

bool is_polyhedron(FaceStream faces, size_t count) {
  size_t found = 0;
  for (size_t at = 0; at < faces.size(); at += size_t{faces[at]} + 1, ++found) {
    if (faces[at] < 3 || faces[at] >= faces.size() - at) return false;
  }
  return found == count && count >= 4;
}

}  // namespace isosplat::import
