#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "shared/core/unstructured/mesh.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// An unstructured mesh in memory.
struct OpenMesh {
  UnstructuredMesh mesh;
  std::string name;  ///< the file's name without its suffix
  std::vector<std::string> notes;
  std::vector<std::filesystem::path> files;
};

/// Whether a file begins as an unstructured grid of VTK's XML format (.vtu, .pvtu).
bool is_vtk_mesh(std::string_view beginning);

/// Reads an unstructured grid with the values of one array (choose_vtk_xml_array), of all pieces.
/// Values of cells are averaged at the points, with a note; cells without a value (NaN or
/// options.missing_value) are left out, with their number. `memory_bytes`: limit of the memory.
/// Errors: those of read_vtk_xml, choose_vtk_xml_array and add_vtk_cells; malformed_volume for
/// positions that are not finite and pieces without the array; invalid_argument for options that do
/// not fit; out_of_memory, before memory is allocated.
Result<OpenMesh> open_vtk_mesh(const std::filesystem::path& path, const ImportOptions& options,
                               uint64_t memory_bytes);

}  // namespace isosplat::import
