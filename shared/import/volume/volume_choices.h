#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/time_axis.h"

namespace isosplat::import {

/// No more time steps or channels than this are offered: a longer list is of no use to a user.
inline constexpr size_t kMaxOffered = 10000;

/// Writes volumes to options.choices, unless that is null: see ImportOptions.
void offer(const ImportOptions& options, std::vector<VolumeChoice> volumes);

/// Offers time steps 0 to count − 1.
void offer_steps(const ImportOptions& options, uint64_t count, const TimeAxis& times = {});

/// A channel as its file describes it.
struct ChannelDescription {
  std::string name;                            ///< may be empty
  std::optional<std::array<float, 3>> colour;  ///< sRGB, 0 … 1
};

/// Offers channels 0 to count − 1. `described`: the first channels.
void offer_channels(const ImportOptions& options, uint64_t count,
                    const std::vector<ChannelDescription>& described = {});

/// Offers the allowance whose flag an error's message recommends, if there is one and no other
/// choice is offered.
void offer_allowance(const ImportOptions& options, std::string_view message);

}  // namespace isosplat::import
