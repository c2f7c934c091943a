#pragma once

#include <vector>

#include "shared/import/vtk_mesh/mesh_builder.h"
#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// The cells of a piece, added to a mesh.
struct AddedCells {
  /// For each cell that was added, the number of the file's cell that it is, or is a part of.
  std::vector<uint32_t> numbers;
  uint64_t cells = 0;    ///< of the file that were added
  uint64_t divided = 0;  ///< of these, those that became several
  uint64_t flat = 0;     ///< cells that are no volumes: points, lines, faces
  uint64_t ghosts = 0;   ///< cells that are repeated or hidden
};

/// Adds the cells of a piece of an unstructured grid: linear and quadratic ones (division_of), and
/// polyhedra and prisms (add_polyhedron; VTK's cell types 42, 15 and 16). The mesh has the points
/// of the piece as its last ones. Errors: those of visit_vtk_xml_numbers; unsupported_format for
/// other cells that are volumes, with what to do; malformed_volume for offsets, types and points
/// that do not fit; out_of_memory if the cells need more than `memory_bytes`, before they are
/// allocated.
Result<AddedCells> add_vtk_cells(MeshBuilder& builder, const VtkXmlFile& file,
                                 const VtkXmlPiece& piece, uint64_t memory_bytes);

/// The error for a mesh that does not fit.
tl::unexpected<Error> vtk_mesh_too_large(const std::filesystem::path& path, uint64_t memory_bytes);

}  // namespace isosplat::import
