#pragma once

#include <vector>

#include "shared/import/tiff/choice.h"
#include "shared/import/tiff/source.h"

namespace isosplat::import {

/// The places of a volume's slices. Errors: truncated or malformed_volume if the file has another
/// number of pages than the description says; unsupported_format, io_error and malformed_volume for
/// files that an OME-TIFF names. Pages that are missing, if options.allowed permits it, are missing
/// slices, with a note. `series`: all of the file.
Result<std::vector<TiffSlice>> tiff_slices(const std::filesystem::path& path,
                                           const TiffPages& pages,
                                           const std::vector<TiffSeries>& series,
                                           const TiffVolume& volume, Allowances allowed,
                                           std::vector<std::string>& notes);

}  // namespace isosplat::import
