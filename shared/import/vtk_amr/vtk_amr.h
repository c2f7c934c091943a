#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "shared/core/adaptive/adaptive_grid.h"
#include "shared/core/grid/volume_header.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// An adaptive grid in memory, with all patches; AdaptiveGrid::resolve() has been called.
struct OpenAdaptiveGrid {
  AdaptiveGrid grid;
  VolumeHeader header;  ///< its grid has the nodes of level 0, without their number
  std::vector<std::string> notes;
  std::vector<std::filesystem::path> files;
};

/// Whether a file begins as a hierarchy of grids of VTK's XML format (.vthb, .vth).
bool is_vtk_amr(std::string_view beginning);

/// Opens a hierarchy of grids of VTK's XML format: reads the values of all patches, which are
/// images
/// (.vti), into memory. The domain is the bounding box of the patches of level 0. `memory_bytes`:
/// limit of the memory. Errors: those of read_vtk_hierarchy, open_vtk_xml and AdaptiveGrid, with
/// the patch; malformed_volume for patches whose file contradicts the hierarchy; invalid_argument
/// for options that do not fit; out_of_memory, before memory is allocated.
Result<OpenAdaptiveGrid> open_vtk_amr(const std::filesystem::path& path,
                                      const ImportOptions& options, uint64_t memory_bytes);

}  // namespace isosplat::import
