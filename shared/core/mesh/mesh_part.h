#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "isosplat/points.h"

namespace isosplat {

/// Values of fields at points or vertices, in units of the fields: an array for each field, with
/// one number for each point. NaN: missing.
using FieldValues = std::vector<std::vector<float>>;

/// Points, and the values of fields there.
struct PointsWithFields : PointArrays {
  FieldValues fields;
};

/// Appends to the values of each field those of the same field. No fields: the first values.
inline void append_values(FieldValues& values, const FieldValues& more) {
  if (values.empty()) values.resize(more.size());
  for (size_t i = 0; i < more.size(); ++i) {
    values[i].insert(values[i].end(), more[i].begin(), more[i].end());
  }
}

/// A part of a mesh. Vertices are numbered over all parts, from 0 in the order in which they are
/// written; triangles refer to vertices of this part and of earlier ones.
struct MeshPart {
  PointsWithFields vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< counter-clockwise seen from smaller values
};

/// Appends the next part of a mesh to its earlier parts.
inline void append_part(MeshPart& mesh, const MeshPart& part) {
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(mesh.vertices.positions, part.vertices.positions);
  append(mesh.vertices.normals, part.vertices.normals);
  append_values(mesh.vertices.fields, part.vertices.fields);
  append(mesh.triangles, part.triangles);
}

struct MeshCounts {
  uint64_t vertices = 0, triangles = 0;
};

}  // namespace isosplat
