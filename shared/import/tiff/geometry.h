#pragma once

#include <string>
#include <vector>

#include "shared/import/geometry/conventions.h"
#include "shared/import/tiff/series.h"
#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// The distances between voxels: those of the options, of the series' description, or of the page's
/// resolution. Notes state assumptions.
HeaderGeometry tiff_geometry(const TiffPage& page, const TiffSeries& series,
                             const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace isosplat::import
