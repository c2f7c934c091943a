#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isosplat/points.h"

namespace isosplat {

/// A part of a mesh. Vertices are numbered over all parts, from 0 in the order in which they are
/// written; triangles refer to vertices of this part and of earlier ones.
struct MeshPart {
  PointArrays vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< counter-clockwise seen from smaller values
};

/// Appends the next part of a mesh to its earlier parts.
inline void append_part(MeshPart& mesh, const MeshPart& part) {
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(mesh.vertices.positions, part.vertices.positions);
  append(mesh.vertices.normals, part.vertices.normals);
  append(mesh.triangles, part.triangles);
}

struct MeshCounts {
  uint64_t vertices = 0, triangles = 0;
};

}  // namespace isosplat
