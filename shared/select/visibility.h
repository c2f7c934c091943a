#pragma once

#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "shared/grid/grid.h"
#include "shared/grid/region_mask.h"

namespace isosplat {

/// What is known of whether a block can be seen in a view.
enum class Visibility : uint8_t {
  unknown,  ///< nothing
  coarse,   ///< something larger that the block is a part of may be seen
  seen,     ///< the block may be seen
  hidden,   ///< the block is behind what is drawn
};

/// Which blocks may be seen in one view, told by a test of what is drawn: where a coarse chunk is
/// drawn, its active cells enclose all that finer chunks would draw there, so a region none of
/// whose cells is in front of the picture can be left as it is.
class VisibilityMap {
 public:
  void clear();

  /// A test's answer for a drawn chunk of this block: the regions that were tested, and which of
  /// them may be seen.
  void add(BlockKey block, const RegionMask& tested, const RegionMask& seen);

  Visibility of(BlockKey block) const;

 private:
  std::unordered_map<uint64_t, RegionMask> tested_;  ///< by block quantized value
  std::unordered_set<uint64_t>
      seen_;  ///< quantized values of blocks that regions cover, and all above them
};

}  // namespace isosplat
