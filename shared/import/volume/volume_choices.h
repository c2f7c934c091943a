#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// Puts volumes into options.choices, if the caller wants them: see ImportOptions.
void offer(const ImportOptions& options, std::vector<VolumeChoice> volumes);

/// Offers time steps 0 to count − 1.
void offer_steps(const ImportOptions& options, uint64_t count);

/// Offers channels 0 to count − 1. `names`: of the first ones; may be fewer.
void offer_channels(const ImportOptions& options, uint64_t count,
                    const std::vector<std::string>& names = {});

/// Offers the allowance whose flag an error's message advises, if there is one and nothing else is
/// offered.
void offer_allowance(const ImportOptions& options, std::string_view message);

}  // namespace isosplat::import
