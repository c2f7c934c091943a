#include "native/builder/block_worker.h"

#include <algorithm>

#include "shared/preprocess/block_storage_weight.h"
#include "shared/preprocess/coarsen.h"
#include "shared/preprocess/round_intervals.h"
#include "shared/preprocess/size_forecast.h"

namespace isosplat {

void BlockWorker::encode(const Layer& layer, Index3 block, const CoarserLayer& coarser,
                         const BandOptions& options, double max_bytes, SharedBands& bands,
                         EncodedBlock& out) {
  gather_block(layer, block, block_);
  if (layer.grid.level > 0) round_intervals(block_);
  find_row_intervals(block_);
  if (coarser.voxels) coarsen_block(layer, block_, coarser);
  planner_.count(block_.intervals);
  if (layer.grid.level == 0) statistics.add_block(planner_, block_.intervals);
  out.interval = planner_.interval();
  const BlockVoxels voxels{block_.cells, block_.voxels.data(), block_.intervals.data(),
                           layer.grid.level > 0, block_.row_intervals.data()};
  BandOptions chosen = options;
  for (;; chosen.storage_weight = std::min(kMaxStorageWeight, 3 * chosen.storage_weight)) {
    out.storage_weight = chosen.storage_weight;
    out.bands.clear();
    out.bytes.clear();
    const std::vector<uint32_t>& ends = planner_.plan(
        block_options(chosen, layer.grid.level, planner_.cells(), block_.intervals.size()));
    masks_.set(voxels, out.interval.min, ends);
    bands.encode(encoder_, voxels, masks_, out.interval.min, ends, out.bands, out.bytes);
    const bool fits = static_cast<double>(out.bytes.size()) <= max_bytes;
    if (fits || ends.size() <= 1 || chosen.storage_weight >= kMaxStorageWeight) return;
  }
}

}  // namespace isosplat
