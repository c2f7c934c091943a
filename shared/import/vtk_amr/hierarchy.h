#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/base/vec3.h"

namespace isosplat::import {

/// A patch of a file of VTK's XML format: its first and last cell along each axis, in cells of its
/// level, and the file with its values.
struct VtkAmrPatch {
  std::array<int64_t, 3> low{}, high{};
  std::filesystem::path file;
};

struct VtkAmrLevel {
  Vec3d spacing;  ///< > 0
  std::vector<VtkAmrPatch> patches;
};

/// A file of the types vtkHierarchicalBoxDataSet and vtkOverlappingAMR (.vthb, .vth):
///
///     <VTKFile type="vtkOverlappingAMR" version="1.1">
///       <vtkOverlappingAMR origin="0 0 0" grid_description="XYZ">
///         <Block level="0" spacing="1 1 1">
///           <DataSet index="0" amr_box="0 7 0 7 0 7" file="a/a_0.vti"/>
///
/// The world position of the corner of cell (i, j, k) of a level is origin + spacing ∘ (i, j, k).
struct VtkHierarchy {
  Vec3d origin;
  std::vector<VtkAmrLevel> levels;  ///< the coarsest first; at least one
};

/// Reads a hierarchy, without the files of its patches. Errors: io_error, truncated,
/// malformed_volume, unsupported_format (versions before 1.1, which state no positions, and grids
/// of two dimensions).
Result<VtkHierarchy> read_vtk_hierarchy(const std::filesystem::path& path);

}  // namespace isosplat::import
