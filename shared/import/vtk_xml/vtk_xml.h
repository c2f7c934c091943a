#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether a file begins as one of VTK's XML files of images or rectilinear grids.
bool is_vtk_xml(std::string_view beginning);

/// Opens an image of VTK's XML format (.vti, .pvti), or a rectilinear grid (.vtr, .pvtr) with even
/// spacing. Errors: those of open_volume.
Result<OpenVolume> open_vtk_xml(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
