#pragma once

#include <vector>

#include "shared/core/unstructured/level_plan.h"

namespace isosplat {

/// A face of a cell with a size (UnstructuredMesh::size()), beyond which there is no other one.
struct BoundaryFace {
  uint32_t cell = 0;
  uint8_t face = 0;  ///< index in faces_of()
};

/// The corners of a face, and its number of corners (3 or 4).
struct FaceCorners {
  std::array<Vec3d, 4> at;
  size_t count = 3;
};
FaceCorners corners_of(const UnstructuredMesh& mesh, const BoundaryFace& face);
Box box_of(const UnstructuredMesh& mesh, const BoundaryFace& face);

/// The unit normal that points out of the face's cell; 0 for a face without an area.
Vec3d outward_normal(const UnstructuredMesh& mesh, const BoundaryFace& face);

/// The faces of cells with a size that no such cell on their other side shares, by the positions of
/// their corners: two blocks that touch, with points of their own, have no boundary between them.
/// Of cells that are listed several times, the faces of the first one are found. A face whose
/// surroundings lie in other cells, such as one with hanging nodes, is none either: 1/1000 of its
/// size before its centre and its corners. A gap that is thinner than that is not seen.
///
/// Faces are compared with those that have the same first corner, as many at a time as fit into
/// `memory_bytes`. `survey`: of the mesh. Errors: out_of_memory.
Result<std::vector<BoundaryFace>> boundary_faces(const UnstructuredMesh& mesh,
                                                 const MeshSurvey& survey, uint64_t memory_bytes);

}  // namespace isosplat
