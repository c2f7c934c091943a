#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "native/import/nrrd_header.h"
#include "native/import/orientation.h"

namespace isosplat {

/// What the axes of an NRRD file are: three of space, and at most one more of more than one sample.
struct NrrdAxes {
  Vec3<int64_t> voxels;     ///< along the axes of space, in the file's order
  HeaderGeometry geometry;  ///< in LPS and millimetres
  size_t step_axis = 3;     ///< where the other axis is among the four; 3 where there is none
  int64_t steps = 1;        ///< its size
  std::vector<std::string> notes;
};

/// Reads axes and geometry. Axes of one sample that are not of space do not count.
///
/// An axis is one of space where it has a space direction; where none has, where its kind says
/// "domain" or "space"; and where nothing is said, the first three are.
///
/// Errors: malformed_volume; unsupported_type where voxels are vectors, colours or matrices;
/// no_cells for images; unsupported_format for more than one other axis.
Result<NrrdAxes> read_nrrd_axes(const std::filesystem::path& path, const NrrdHeader& header);

}  // namespace isosplat
