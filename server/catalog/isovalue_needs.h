#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// The chunks that an isovalue needs of a level.
struct IsovalueNeeds {
  double isovalue = 0;
  uint64_t chunks = 0;
  uint64_t bytes = 0;  ///< of the chunks
  uint64_t cells = 0;  ///< in the chunks; some may not be active at this isovalue
};

/// The needs of these isovalues, computed from the chunks of the level (at least those that one of
/// the isovalues needs).
std::vector<IsovalueNeeds> isovalue_needs(std::span<const double> isovalues,
                                          const ValueMapping& mapping,
                                          std::span<const ChunkRef> chunks);

}  // namespace isosplat::server
