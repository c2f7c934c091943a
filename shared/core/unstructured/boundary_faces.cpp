#include "shared/core/unstructured/boundary_faces.h"

#include <algorithm>
#include <tuple>

namespace isosplat {
namespace {

constexpr double kBeforeFace = 1e-3;

/// A face by its corners in ascending order, as a 64-bit hash (splitmix64's finalizer).
uint64_t hash_of(std::array<uint32_t, 4> corners) {
  std::sort(corners.begin(), corners.end());
  uint64_t hash = 0;
  for (const uint32_t corner : corners) {
    hash = (hash ^ corner) + 0x9e3779b97f4a7c15u;
    hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ hash >> 27) * 0x94d049bb133111ebu;
    hash ^= hash >> 31;
  }
  return hash;
}

struct HashedFace {
  uint64_t hash;
  BoundaryFace face;
};

/// Whether other cells lie before all parts of a face.
bool is_covered(const UnstructuredMesh& mesh, const Bins& cells, const BoundaryFace& face) {
  const FaceCorners corners = corners_of(mesh, face);
  const Vec3d normal = outward_normal(mesh, face);
  Vec3d centre{0, 0, 0};
  double size = 0;
  for (size_t i = 0; i < corners.count; ++i) {
    centre = centre + corners.at[i] * (1.0 / static_cast<double>(corners.count));
    size = std::max(size, length(corners.at[i] - corners.at[0]));
  }
  const auto is_inside = [&](Vec3d at) {
    return locate(mesh, cells, at + normal * (size * kBeforeFace)).has_value();
  };
  if (!is_inside(centre)) return false;
  for (size_t i = 0; i < corners.count; ++i) {
    if (!is_inside(corners.at[i] * 0.9 + centre * 0.1)) return false;
  }
  return true;
}

/// Whether cells lie on both sides of a face. `same`: the faces with its corners, in order of
/// cells.
bool has_other_side(const UnstructuredMesh& mesh, std::span<const HashedFace> same) {
  if (same.size() < 2) return false;
  const Vec3d normal = outward_normal(mesh, same[0].face);
  return std::any_of(same.begin() + 1, same.end(), [&](const HashedFace& other) {
    return dot(normal, outward_normal(mesh, other.face)) < 0;
  });
}

}  // namespace

FaceCorners corners_of(const UnstructuredMesh& mesh, const BoundaryFace& face) {
  const CellFace& of = faces_of(mesh.shapes[face.cell])[face.face];
  const auto points = mesh.corners_of(face.cell);
  FaceCorners corners;
  corners.count = of[3] < 0 ? 3 : 4;
  for (size_t i = 0; i < corners.count; ++i) {
    corners.at[i] = mesh.points[points[static_cast<size_t>(of[i])]];
  }
  return corners;
}

Vec3d outward_normal(const UnstructuredMesh& mesh, const BoundaryFace& face) {
  const FaceCorners corners = corners_of(mesh, face);
  const auto& at = corners.at;
  const Vec3d area = corners.count == 3 ? cross(at[1] - at[0], at[2] - at[0])
                                        : cross(at[2] - at[0], at[3] - at[1]);
  const double size = length(area);
  if (!(size > 0)) return {0, 0, 0};
  const CellGeometry cell = mesh.geometry(face.cell);
  Vec3d centre{0, 0, 0};
  for (size_t i = 0; i < static_cast<size_t>(cell.count()); ++i) centre = centre + cell.corners[i];
  const Vec3d inward = centre * (1.0 / cell.count()) - at[0];
  return area * ((dot(area, inward) > 0 ? -1 : 1) / size);  // files have cells of both orientations
}

Result<std::vector<BoundaryFace>> boundary_faces(const UnstructuredMesh& mesh, const Bins& cells,
                                                 std::span<const float> sizes,
                                                 uint64_t memory_bytes) {
  size_t count = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) count += faces_of(mesh.shapes[cell]).size();
  if (count * sizeof(HashedFace) + mesh.points.size() * 8 > memory_bytes) {
    return fail(Status::out_of_memory,
                "an unstructured grid: expected cells whose faces fit into " +
                    std::to_string(memory_bytes >> 20) + " MiB, found more: raise --memory");
  }
  std::vector<HashedFace> faces;
  faces.reserve(count);
  {
    const std::vector<uint32_t> first = first_at_position(mesh.points);
    for (size_t cell = 0; cell < mesh.cells(); ++cell) {
      if (!(sizes[cell] > 0)) continue;
      const auto points = mesh.corners_of(cell);
      const auto of_cell = faces_of(mesh.shapes[cell]);
      for (size_t i = 0; i < of_cell.size(); ++i) {
        std::array<uint32_t, 4> corners{};
        for (size_t k = 0; k < 4; ++k) {
          corners[k] = of_cell[i][k] < 0 ? ~0u : first[points[static_cast<size_t>(of_cell[i][k])]];
        }
        faces.push_back({hash_of(corners), {static_cast<uint32_t>(cell), static_cast<uint8_t>(i)}});
      }
    }
  }
  std::sort(faces.begin(), faces.end(), [](const HashedFace& a, const HashedFace& b) {
    return std::tie(a.hash, a.face.cell, a.face.face) < std::tie(b.hash, b.face.cell, b.face.face);
  });
  std::vector<BoundaryFace> found;
  for (size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    while (end < faces.size() && faces[end].hash == faces[begin].hash) ++end;
    const auto same = std::span(faces).subspan(begin, end - begin);
    if (!has_other_side(mesh, same) && !is_covered(mesh, cells, same[0].face)) {
      found.push_back(same[0].face);
    }
  }
  return found;
}

}  // namespace isosplat
