#pragma once

#include <string>
#include <vector>

#include "shared/import/conventions.h"
#include "shared/import/open_volume.h"
#include "shared/import/tiff_series.h"

namespace isosplat {

/// The distances between voxels: those of the options, of the series' description, or of the page's
/// resolution. A note says what was assumed.
HeaderGeometry tiff_geometry(const TiffPage& page, const TiffSeries& series,
                             const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace isosplat
