#pragma once

#include <filesystem>
#include <vector>

#include "shared/core/unstructured/mesh.h"
#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// An unstructured mesh in memory.
struct OpenMesh {
  UnstructuredMesh mesh;
  std::string name;    ///< the file's name without its suffix
  std::string format;  ///< "VTK XML" or "VTK"
  std::vector<std::string> notes;
  std::vector<std::filesystem::path> files;
};

/// Whether a file is an unstructured grid (.vtu, .pvtu), a structured one, whose lattice is
/// curvilinear (.vts, .pvts), or a rectilinear one with uneven spacing (.vtr, .pvtr), of VTK's XML
/// format. Of rectilinear grids, the positions are read.
bool is_vtk_mesh(const FileHead& head);

/// Reads such a grid with the values of one array (choose_vtk_xml_array), of all pieces. Cells of
/// lattices become hexahedra.
/// Values of cells are averaged at the points, with a note; cells without a value (NaN or
/// options.missing_value) are left out, with their number. `memory_bytes`: limit of the memory.
/// Errors: those of read_vtk_xml_pieces, choose_vtk_xml_array, add_vtk_points, add_vtk_cells and
/// add_vtk_lattice_cells; malformed_volume for pieces without the array; unsupported_format for
/// lattices of less than three dimensions; invalid_argument for options that do
/// not fit; out_of_memory, before memory is allocated.
Result<OpenMesh> open_vtk_mesh(const std::filesystem::path& path, const ImportOptions& options,
                               uint64_t memory_bytes);

}  // namespace isosplat::import
