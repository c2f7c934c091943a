#pragma once

#include <vector>

#include "shared/core/unstructured/mesh.h"
#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// The cells of a piece, added to a mesh.
struct AddedCells {
  std::vector<uint32_t> numbers;  ///< of the cells in the file that were added
  uint64_t flat = 0;              ///< cells that are no volumes: points, lines, faces
  uint64_t ghosts = 0;            ///< cells that are repeated or hidden
};

/// Adds the cells of a piece of an unstructured grid: tetrahedra, voxels, hexahedra, wedges and
/// pyramids (VTK's cell types 10 to 14). The mesh has the points of the piece as its last ones.
/// Errors: those of visit_vtk_xml_numbers; unsupported_format for other cells that are volumes,
/// with what to do; malformed_volume for offsets, types and points that do not fit;
/// out_of_memory if the cells need more than `memory_bytes`, before they are allocated.
Result<AddedCells> add_vtk_cells(UnstructuredMesh& mesh, const VtkXmlFile& file,
                                 const VtkXmlPiece& piece, uint64_t memory_bytes);

/// The error for a mesh that does not fit.
tl::unexpected<Error> vtk_mesh_too_large(const std::filesystem::path& path, uint64_t memory_bytes);

}  // namespace isosplat::import
