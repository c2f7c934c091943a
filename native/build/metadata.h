#pragma once

#include <string>

#include "native/build/builder.h"
#include "native/build/statistics.h"

namespace isosplat {

/// The most bytes that metadata_json() can return for a volume of these dimensions, and at most
/// what a store's head can hold.
size_t metadata_limit(const VolumeHeader& header, const BuildOptions& options);

/// The metadata of a store as JSON text (FORMAT.md lists its keys), within metadata_limit().
std::string metadata_json(const VolumeHeader& header, const BuildOptions& options,
                          const StoreInfo& info, const VolumeStatistics& statistics);

}  // namespace isosplat
