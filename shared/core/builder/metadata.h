#pragma once

#include <string>

#include "shared/core/builder/store_options.h"
#include "shared/core/grid/volume_header.h"
#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// Upper limit of the size of metadata_json() for a volume of these dimensions, in bytes. At most
/// kMaxMetadataBytes.
size_t metadata_limit(const VolumeHeader& header, const StoreOptions& options);

/// Numbers of voxels in bins of equal width over the values [low, high].
struct ValueHistogram {
  double low = 0, high = 0;
  std::vector<uint64_t> counts;  ///< at most 256
};
ValueHistogram value_histogram(const ValueMapping& mapping, const VolumeStatistics& statistics);

/// Isovalues of the volume's boundaries, best first, rounded to few digits. At most five.
std::vector<double> suggested_isovalues(const ValueMapping& mapping,
                                        const VolumeStatistics& statistics);

/// The metadata of a store as JSON text (FORMAT.md lists its keys), within metadata_limit().
std::string metadata_json(const VolumeHeader& header, const StoreOptions& options,
                          const StoreInfo& info, const VolumeStatistics& statistics);

}  // namespace isosplat
