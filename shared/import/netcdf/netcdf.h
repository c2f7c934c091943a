#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether a file begins as one in netCDF's classic format. netCDF-4 is HDF5.
bool is_netcdf(std::string_view beginning);

/// Opens a variable of a file in netCDF's classic format (CDF-1, -2, -5), by the conventions of CF.
/// options.dataset, or without it the file's only volume; options.time_step and options.channel
/// choose elements of axes of times and channels. Errors: those of open_volume.
Result<OpenVolume> open_netcdf(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
