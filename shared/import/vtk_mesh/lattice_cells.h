#pragma once

#include "shared/import/vtk_mesh/cells.h"

namespace isosplat::import {

/// Adds the cells of a piece of a structured or rectilinear grid as hexahedra. The mesh has the
/// points of the piece as its last ones. `used`: the points whose cells are added. Cells with ghost
/// flags, and those with a hidden point, are left out. Errors: those of left_out_vtk_cells;
/// out_of_memory if the cells need more than `memory_bytes`, before they are allocated.
Result<AddedCells> add_vtk_lattice_cells(MeshBuilder& builder, const VtkXmlFile& file,
                                         const VtkXmlPiece& piece, const VtkXmlExtent& used,
                                         uint64_t memory_bytes);

}  // namespace isosplat::import
