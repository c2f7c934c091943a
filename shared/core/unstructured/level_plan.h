#pragma once

#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/unstructured/cell_bins.h"

namespace isosplat {

/// The cells of a mesh that have values and a volume, their bounding box and range of values.
struct MeshSurvey {
  Box box;
  double low = 0, high = 0;
  std::vector<float> sizes;  ///< UnstructuredMesh::size() of each cell
  float smallest = 0, largest = 0;
  uint64_t cells = 0;
};

/// Errors: malformed_volume if there is no such cell.
Result<MeshSurvey> survey_mesh(const UnstructuredMesh& mesh);

/// Level 0 of the grid: cells as large as the largest ones of the mesh, and an integer number of
/// them along each axis of its bounding box.
struct LevelPlan {
  Index3 cells;
  Vec3d origin, spacing;
  uint32_t finer = 0;  ///< further levels, each with a ratio of 2
};

/// `finest`: the smallest edge of grid cells, relative to those of the mesh. `voxels`: the most
/// voxels that the finest level may have.
LevelPlan plan_levels(const MeshSurvey& survey, double finest, uint64_t voxels);

/// Bins over the bounding box, about one for each cell.
BinGrid plan_bins(const MeshSurvey& survey);

}  // namespace isosplat
