#pragma once

#include <string>

#include "native/builder/builder.h"
#include "shared/preprocess/statistics.h"

namespace isosplat {

/// The most bytes that metadata_json() can return for a volume of these dimensions, and at most
/// what a store's header can hold.
size_t metadata_limit(const VolumeHeader& header, const BuildOptions& options);

/// Voxels in equal parts of the values [low, high].
struct ValueHistogram {
  double low = 0, high = 0;
  std::vector<uint64_t> counts;  ///< at most 256
};
ValueHistogram value_histogram(const ValueMapping& mapping, const VolumeStatistics& statistics);

/// Isovalues at which the volume's boundaries lie, best first, rounded so that they read well. At
/// most five.
std::vector<double> suggested_isovalues(const ValueMapping& mapping,
                                        const VolumeStatistics& statistics);

/// The metadata of a store as JSON text (FORMAT.md lists its keys), within metadata_limit().
std::string metadata_json(const VolumeHeader& header, const BuildOptions& options,
                          const StoreInfo& info, const VolumeStatistics& statistics);

}  // namespace isosplat
