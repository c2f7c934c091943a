#pragma once

#include <vector>

#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// Which cells of a piece its ghost flags (vtkGhostType, vtkGhostLevels) leave out: those that
/// another piece has too, that finer cells replace, or that are hidden. One for each of `cells`
/// cells, or none if nothing is left out. Errors: those of visit_vtk_xml_numbers.
Result<std::vector<bool>> left_out_vtk_cells(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                             uint64_t cells);

/// Which points of a piece are hidden; the cells of a lattice around them are hidden too. One for
/// each of `points` points, or none. Errors: as above.
Result<std::vector<bool>> hidden_vtk_points(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                            uint64_t points);

}  // namespace isosplat::import
