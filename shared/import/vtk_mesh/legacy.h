#pragma once

#include "shared/import/vtk_xml/pieces.h"

namespace isosplat::import {

/// Reads a legacy VTK file with an unstructured, structured or rectilinear grid, without its
/// values, in the terms of VTK's XML format: one piece, with arrays at offsets. Errors: those of
/// read_vtk_sections; truncated if the file ends within values; malformed_volume for numbers of
/// points and cells that contradict each other.
Result<VtkXmlPieces> read_vtk_legacy_mesh(const std::filesystem::path& path);

}  // namespace isosplat::import
