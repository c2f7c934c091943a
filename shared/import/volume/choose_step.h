#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/time_axis.h"

namespace isosplat::import {

/// Selects a time step of a volume with `sizes` along its axes (fastest first; trailing axes of
/// size 1 are ignored). Returns 0 for a volume without a time axis. Errors: no_cells for 2D,
/// unsupported_format for more than 4 axes, invalid_argument for a 4D volume without a valid time
/// step, or for a time step of a volume without a time axis. `times`: of the steps, for the
/// choices.
Result<uint64_t> choose_time_step(const std::filesystem::path& path,
                                  const std::vector<int64_t>& sizes, const ImportOptions& options,
                                  const TimeAxis& times = {});

/// Selects one of `steps` volumes by the options; 0 if there is only one. Errors: invalid_argument
/// if there are several and --time-step is missing or out of range. `times`: as above.
Result<uint64_t> choose_step(const std::filesystem::path& path, int64_t steps,
                             const ImportOptions& options, const TimeAxis& times = {});

}  // namespace isosplat::import
