#pragma once

#include <vector>

#include "shared/import/vtk_xml/document.h"

namespace isosplat::import {

/// The faces of all polyhedra of a piece.
struct PolyhedronFaces {
  /// Of each polyhedron its number of faces, and then of each face the number of its points and the
  /// points.
  std::vector<uint32_t> stream;
  std::vector<uint32_t> ends;  ///< of each cell in the stream; cells of other types have no part
};

/// Whether a piece has the faces of its polyhedra in tables (version 2.3 of the format, VTK 9.4).
bool has_polyhedron_tables(const VtkXmlPiece& piece);

/// Reads these tables: `polyhedron_offsets`, the end of each cell in `polyhedron_to_faces`, which
/// are numbers of faces, and `face_offsets`, the end of each face in `face_connectivity`. Errors:
/// those of visit_vtk_xml_numbers; malformed_volume for missing tables, ends that decrease and
/// numbers that are negative or too large; out_of_memory if they need more than `memory_bytes`,
/// before they are allocated.
Result<PolyhedronFaces> read_polyhedron_tables(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                               uint64_t memory_bytes);

}  // namespace isosplat::import
