#pragma once

#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "shared/core/grid/grid.h"
#include "shared/core/grid/region_mask.h"

namespace isosplat {

/// The result of occlusion queries for a block in a camera view.
enum class Visibility : uint8_t {
  untested,          ///< no query has covered the block
  ancestor_visible,  ///< a larger block that contains it may be visible; no query tested it alone
  visible,           ///< the block may be visible
  hidden,            ///< the block is occluded
};

/// The visibility of blocks in one camera view, from the results of occlusion queries.
///
/// The active cells of a coarse chunk enclose everything that finer chunks would draw in the same
/// place. If no active cell of a region lies in front of the picture, the region is hidden at every
/// finer level, and need not be refined.
class VisibilityMap {
 public:
  void clear();

  /// Adds the result of a query for a drawn chunk of this block: the regions that were tested, and
  /// those of them that may be visible.
  void add(BlockKey block, const RegionMask& tested, const RegionMask& visible);

  Visibility of(BlockKey block) const;

 private:
  std::unordered_map<uint64_t, RegionMask> tested_;  ///< by block_id
  /// block_id of the blocks that visible regions cover, and of all their ancestors.
  std::unordered_set<uint64_t> visible_;
};

}  // namespace isosplat
