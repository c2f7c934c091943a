#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"

namespace isosplat::import {

/// No more time steps or channels than this are offered: a longer list is of no use to a user.
inline constexpr size_t kMaxOffered = 10000;

/// Writes volumes to options.choices, unless that is null: see ImportOptions.
void offer(const ImportOptions& options, std::vector<VolumeChoice> volumes);

/// Offers time steps 0 to count − 1.
void offer_steps(const ImportOptions& options, uint64_t count);

/// Offers channels 0 to count − 1. `names`: names of the first channels.
void offer_channels(const ImportOptions& options, uint64_t count,
                    const std::vector<std::string>& names = {});

/// Offers the allowance whose flag an error's message recommends, if there is one and no other
/// choice is offered.
void offer_allowance(const ImportOptions& options, std::string_view message);

}  // namespace isosplat::import
