#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {

/// Selects one of the `count` numbers of each voxel by the options; 0 if there is only one.
/// `described`: for the choices, and for messages, which list their names. `which`: what the
/// message says after "channels". Errors: unsupported_type if there are several and --channel is
/// missing; invalid_argument if it is out of range.
Result<uint64_t> choose_channel(const std::filesystem::path& path, uint64_t count,
                                const ImportOptions& options,
                                const std::vector<ChannelDescription>& described = {},
                                std::string_view which = "");

/// Red, green, blue and alpha.
std::vector<ChannelDescription> rgba_channels();

}  // namespace isosplat::import
