#pragma once

#include "shared/core/adaptive/adaptive_grid.h"
#include "shared/core/unstructured/level_plan.h"
#include "shared/core/unstructured/near_cells.h"
#include "shared/core/unstructured/near_faces.h"

namespace isosplat {

/// Refines the grid cells of level 0, one after another (resample() says by which rules), and adds
/// the leaf cells to a grid.
class Refinement {
 public:
  /// `grid`: empty, with the levels of the plan. `limit`: of the error. `lists_bytes`: limit of the
  /// lists of cells and faces near one grid cell of level 0.
  Refinement(const UnstructuredMesh& mesh, const MeshSurvey& survey, const LevelPlan& plan,
             const std::vector<BoundaryFace>& faces, double limit, uint64_t lists_bytes,
             AdaptiveGrid grid);

  /// `cells`: those of the mesh whose boxes overlap the grid cell of level 0; `faces`: those of
  /// `faces` whose boxes overlap its gap_box(). In ascending order. Errors: out_of_memory.
  Result<void> run(Index3 cell, std::span<const uint32_t> cells, std::span<const uint32_t> faces);

  AdaptiveGrid take() { return std::move(grid_); }

 private:
  struct GridCell {
    uint32_t level = 0;
    Index3 at;
    Box box;
    double edge = 0;  ///< the longest one
  };
  /// A part of lists_.
  struct List {
    size_t begin = 0, end = 0;
    size_t size() const { return end - begin; }
  };
  /// The cells and faces near a grid cell.
  struct Near {
    List cells, faces;
  };
  /// Where the corners of a grid cell are in the mesh, once it is known.
  struct Corners {
    std::array<std::optional<Located>, 8> at;
    std::array<bool, 8> are_known{};
  };

  std::span<const uint32_t> items(const List& list) const {
    return std::span(lists_).subspan(list.begin, list.size());
  }
  GridCell grid_cell(uint32_t level, Index3 at) const;
  GridCell child(const GridCell& cell, int32_t octant) const;
  bool is_larger(const GridCell& cell, uint32_t mesh_cell, const Box& box) const;
  bool is_finest(const GridCell& cell) const { return cell.level == plan_.finer; }
  Result<void> check_lists(uint64_t more_bytes) const;
  Result<void> narrow(const GridCell& cell, const Near& near);
  Result<void> prepare(const GridCell& cell, const Near& near);
  Result<void> visit(const GridCell& cell, const Near& near, Corners& corners);
  Result<void> split(const GridCell& cell, const Near& near, Corners& corners);
  Result<void> decide(const GridCell& cell, const Near& near, bool is_crossed, Corners& corners);
  bool is_wrong(const GridCell& cell, std::span<const uint32_t> cells,
                const std::array<double, 8>& values, float size, double share) const;
  Result<void> add(const GridCell& cell, const std::array<double, 8>& values);

  const UnstructuredMesh& mesh_;
  const MeshSurvey& survey_;
  LevelPlan plan_;
  const std::vector<BoundaryFace>& faces_;
  double limit_;
  uint64_t lists_bytes_;
  AdaptiveGrid grid_;
  NearCells near_cells_;
  NearFaces near_faces_;
  std::vector<uint32_t> lists_;  ///< of the grid cells that are being divided, finer ones last
  Index3 last_{-1, -1, -1};      ///< the grid cell of level 0 before
  Corners last_corners_;
};

}  // namespace isosplat
