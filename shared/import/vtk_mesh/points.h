#pragma once

#include "shared/core/unstructured/mesh.h"
#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// The number of points or cells of a piece; of lattices those of its extent. 2^32 if there are
/// more.
uint64_t vtk_points_of(const VtkXmlFile& file, const VtkXmlPiece& piece);
uint64_t vtk_cells_of(const VtkXmlFile& file, const VtkXmlPiece& piece);

/// Adds the points of a piece to a mesh: those in <Points>, or of a rectilinear grid the products
/// of its coordinates. `total`: the points of all pieces, for which memory is allocated at the
/// first one. Errors: those of visit_vtk_xml_numbers; malformed_volume for positions that are
/// missing or not finite, and for coordinates that neither increase nor decrease.
Result<void> add_vtk_points(UnstructuredMesh& mesh, const VtkXmlFile& file,
                            const VtkXmlPiece& piece, uint64_t total);

}  // namespace isosplat::import
