#pragma once

#include <string_view>

#include "shared/core/builder/store_options.h"
#include "shared/core/grid/volume_header.h"

namespace isosplat {

/// A volume and the options of its build, as JavaScript describes them.
struct DescribedVolume {
  VolumeHeader header;
  StoreOptions options;
  unsigned encoders = 1;  ///< for the memory plan
};

/// Parses the JSON text of a VolumeDescription (web/builder/types.ts). Errors: invalid_argument.
Result<DescribedVolume> parse_volume(std::string_view text);

/// A BuildReport (web/builder/types.ts) as JSON text.
std::string report_text(const BuildReport& report);

}  // namespace isosplat
