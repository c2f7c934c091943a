#include "shared/core/unstructured/boundary_faces.h"

#include <algorithm>
#include <tuple>

namespace isosplat {
namespace {

constexpr double kBeforeFace = 1e-3;
/// Of first_at_position(), for each point.
constexpr uint64_t kPositionBytes = 20;

/// The corners of a face as numbers of positions, in ascending order; those of triangles end with
/// kNoCorner.
using FaceKey = std::array<uint32_t, 4>;
constexpr uint32_t kNoCorner = ~0u;

tl::unexpected<Error> too_many(uint64_t memory_bytes) {
  return fail(Status::out_of_memory, "an unstructured grid: expected cells whose faces fit into " +
                                         std::to_string(memory_bytes >> 20) +
                                         " MiB, found more: raise --memory");
}

struct KeyedFace {
  FaceKey key;
  BoundaryFace face;
};

/// Gives the faces of a mesh as groups with the same corners.
class FaceGroups {
 public:
  FaceGroups(const UnstructuredMesh& mesh, std::span<const float> sizes)
      : mesh_(mesh), sizes_(sizes), first_(first_at_position(mesh.points)) {}

  /// Calls visit(group) for each group, in order of cells and faces.
  template <class Visit>
  Result<void> for_each(uint64_t memory_bytes, const Visit& visit) const {
    // Faces with the same corners have the same first corner.
    std::vector<uint32_t> counts(mesh_.points.size());
    for_each_face([&](const FaceKey& key, BoundaryFace) { ++counts[key[0]]; });
    const uint64_t own = counts.size() * (sizeof(uint32_t) + sizeof(size_t));
    const uint64_t most = (memory_bytes - std::min(memory_bytes, own)) / sizeof(BoundaryFace);
    for (size_t begin = 0, end = 0; begin < counts.size(); begin = end) {
      uint64_t faces = 0;
      for (; end < counts.size() && faces + counts[end] <= most; ++end) faces += counts[end];
      if (end == begin) return too_many(memory_bytes);
      visit_range(counts, begin, end, visit);
    }
    return {};
  }

 private:
  FaceKey key_of(size_t cell, const CellFace& face) const {
    const auto points = mesh_.corners_of(cell);
    FaceKey key;
    for (size_t k = 0; k < key.size(); ++k) {
      key[k] = face[k] < 0 ? kNoCorner : first_[points[static_cast<size_t>(face[k])]];
    }
    std::sort(key.begin(), key.end());
    return key;
  }

  template <class Visit>
  void for_each_face(const Visit& visit) const {
    for (size_t cell = 0; cell < mesh_.cells(); ++cell) {
      if (!(sizes_[cell] > 0)) continue;
      const auto faces = faces_of(mesh_.shapes[cell]);
      for (size_t i = 0; i < faces.size(); ++i) {
        visit(key_of(cell, faces[i]),
              BoundaryFace{static_cast<uint32_t>(cell), static_cast<uint8_t>(i)});
      }
    }
  }

  /// The faces whose first corner is from `begin` to before `end`.
  template <class Visit>
  void visit_range(const std::vector<uint32_t>& counts, size_t begin, size_t end,
                   const Visit& visit) const {
    std::vector<size_t> ends(end - begin);  // at first, where the next face of a corner goes
    size_t total = 0;
    for (size_t i = begin; i < end; ++i) {
      ends[i - begin] = total;
      total += counts[i];
    }
    std::vector<BoundaryFace> faces(total);
    for_each_face([&](const FaceKey& key, BoundaryFace face) {
      if (key[0] >= begin && key[0] < end) faces[ends[key[0] - begin]++] = face;
    });
    std::vector<KeyedFace> keyed;
    for (size_t i = 0, from = 0; i < ends.size(); from = ends[i++]) {
      keyed.clear();
      for (size_t k = from; k < ends[i]; ++k) {
        const auto& of_cell = faces_of(mesh_.shapes[faces[k].cell]);
        keyed.push_back({key_of(faces[k].cell, of_cell[faces[k].face]), faces[k]});
      }
      std::sort(keyed.begin(), keyed.end(), [](const KeyedFace& a, const KeyedFace& b) {
        return std::tie(a.key, a.face.cell, a.face.face) <
               std::tie(b.key, b.face.cell, b.face.face);
      });
      for (size_t first = 0, last = 0; first < keyed.size(); first = last) {
        while (last < keyed.size() && keyed[last].key == keyed[first].key) ++last;
        visit(std::span<const KeyedFace>(keyed).subspan(first, last - first));
      }
    }
  }

  const UnstructuredMesh& mesh_;
  std::span<const float> sizes_;
  std::vector<uint32_t> first_;  ///< of each point, the first one at its position
};

/// Points before the centre of a face and before its corners. If all are in other cells, the face
/// is covered by them.
struct PointsBefore {
  std::array<Vec3d, 5> at;
  size_t count = 0;
};

PointsBefore points_before(const UnstructuredMesh& mesh, const BoundaryFace& face) {
  const FaceCorners corners = corners_of(mesh, face);
  const Vec3d normal = outward_normal(mesh, face);
  Vec3d centre{0, 0, 0};
  double size = 0;
  for (size_t i = 0; i < corners.count; ++i) {
    centre = centre + corners.at[i] * (1.0 / static_cast<double>(corners.count));
    size = std::max(size, length(corners.at[i] - corners.at[0]));
  }
  PointsBefore points;
  const auto add = [&](Vec3d at) {
    points.at[points.count++] = at + normal * (size * kBeforeFace);
  };
  add(centre);
  for (size_t i = 0; i < corners.count; ++i) add(corners.at[i] * 0.9 + centre * 0.1);
  return points;
}

/// Removes the faces that other cells cover. Only the cells near such points are searched.
Result<void> remove_covered(const UnstructuredMesh& mesh, const MeshSurvey& survey,
                            std::vector<BoundaryFace>& faces, uint64_t memory_bytes) {
  const BinGrid grid = plan_bins(survey);
  std::vector<bool> is_searched(grid.count());
  for (const BoundaryFace& face : faces) {
    const PointsBefore points = points_before(mesh, face);
    for (size_t i = 0; i < points.count; ++i) {
      is_searched[grid.flat(grid.bin_of(points.at[i]))] = true;
    }
  }
  const auto near_box = [&](size_t cell) -> std::optional<Box> {
    if (!(survey.sizes[cell] > 0)) return std::nullopt;
    const Box box = mesh.box(cell);
    const auto [low, high] = grid.bins_of(box);
    for (int32_t z = low.z; z <= high.z; ++z) {
      for (int32_t y = low.y; y <= high.y; ++y) {
        for (int32_t x = low.x; x <= high.x; ++x) {
          if (is_searched[grid.flat({x, y, z})]) return box;
        }
      }
    }
    return std::nullopt;
  };
  const auto cells = Bins::create(grid, mesh.cells(), near_box, memory_bytes);
  if (!cells) return tl::unexpected(cells.error());
  std::erase_if(faces, [&](const BoundaryFace& face) {
    const PointsBefore points = points_before(mesh, face);
    return std::all_of(points.at.begin(), points.at.begin() + static_cast<int>(points.count),
                       [&](Vec3d at) { return locate(mesh, *cells, at).has_value(); });
  });
  return {};
}

/// Whether cells lie on both sides of a face. `same`: the faces with its corners, in order of
/// cells.
bool has_other_side(const UnstructuredMesh& mesh, std::span<const KeyedFace> same) {
  if (same.size() < 2) return false;
  const Vec3d normal = outward_normal(mesh, same[0].face);
  return std::any_of(same.begin() + 1, same.end(), [&](const KeyedFace& other) {
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

Box box_of(const UnstructuredMesh& mesh, const BoundaryFace& face) {
  const FaceCorners corners = corners_of(mesh, face);
  Box box{corners.at[0], corners.at[0]};
  for (size_t i = 1; i < corners.count; ++i) box.add(corners.at[i]);
  return box;
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

Result<std::vector<BoundaryFace>> boundary_faces(const UnstructuredMesh& mesh,
                                                 const MeshSurvey& survey, uint64_t memory_bytes) {
  // Half is for the faces that are compared, and half for those that are found.
  const uint64_t positions = mesh.points.size() * kPositionBytes;
  const uint64_t half = (memory_bytes - std::min(memory_bytes, positions)) / 2;
  if (half == 0) return too_many(memory_bytes);
  std::vector<BoundaryFace> found;
  bool do_fit = true;
  const FaceGroups groups(mesh, survey.sizes);
  auto grouped = groups.for_each(half, [&](std::span<const KeyedFace> same) {
    if (has_other_side(mesh, same)) return;
    // A vector that grows needs up to three times its size.
    do_fit = do_fit && found.size() < half / (3 * sizeof(BoundaryFace));
    if (do_fit) found.push_back(same[0].face);
  });
  if (!grouped) return tl::unexpected(grouped.error());
  if (!do_fit) return too_many(memory_bytes);
  if (auto removed = remove_covered(mesh, survey, found, half); !removed) {
    return tl::unexpected(removed.error());
  }
  return found;
}

}  // namespace isosplat
