#include "shared/import/vtk_mesh/ghosts.h"

#include "shared/import/vtk_xml/choose.h"
#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

// vtkDataSetAttributes.h: the other flags are of points and cells that have their values.
constexpr int kDuplicateCell = 1, kRefinedCell = 8, kHiddenCell = 32;
constexpr int kHiddenPoint = 2;

/// The items with one of the flags in vtkGhostType, or, if `has_levels`, above 0 in vtkGhostLevels
/// of older versions.
Result<std::vector<bool>> flagged(const VtkXmlFile& file, const VtkXmlPiece& piece, uint64_t count,
                                  bool of_cells, int flags, bool has_levels) {
  std::vector<bool> found;
  for (const VtkXmlArray& array : piece.arrays) {
    if (array.of_cells != of_cells || !are_vtk_ghost_flags(array) || array.components != 1) {
      continue;
    }
    const bool is_level = array.name == "vtkGhostLevels";
    if (is_level && !has_levels) continue;
    size_t i = 0;
    auto read = visit_vtk_xml_numbers(file, array, count, [&](double value) {
      const bool is_flagged =
          is_level ? value > 0
                   : value > 0 && value <= 255 && (static_cast<int>(value) & flags) != 0;
      // The size in the file has been checked.
      if (is_flagged && found.empty()) found.resize(static_cast<size_t>(count));
      if (is_flagged) found[i] = true;
      ++i;
      return true;
    });
    if (!read) return tl::unexpected(read.error());
  }
  return found;
}

}  // namespace

Result<std::vector<bool>> left_out_vtk_cells(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                             uint64_t cells) {
  return flagged(file, piece, cells, true, kDuplicateCell | kRefinedCell | kHiddenCell, true);
}

Result<std::vector<bool>> hidden_vtk_points(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                            uint64_t points) {
  return flagged(file, piece, points, false, kHiddenPoint, false);
}

}  // namespace isosplat::import
