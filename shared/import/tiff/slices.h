#pragma once

#include <vector>

#include "shared/import/tiff/choice.h"
#include "shared/import/tiff/source.h"

namespace isosplat::import {

/// The locations of a volume's slices. Errors: truncated or malformed_volume if the number of pages
/// differs from the description; unsupported_format, io_error and malformed_volume for files that
/// an OME-TIFF names. If options.allowed permits missing pages, they become missing slices, with a
/// note. `series`: all series of the file.
Result<std::vector<TiffSlice>> tiff_slices(const std::filesystem::path& path,
                                           const TiffPages& pages,
                                           const std::vector<TiffSeries>& series,
                                           const TiffVolume& volume, Allowances allowed,
                                           std::vector<std::string>& notes);

}  // namespace isosplat::import
