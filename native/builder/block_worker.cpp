#include "native/builder/block_worker.h"

#include <algorithm>

#include "shared/preprocess/block_lambda.h"
#include "shared/preprocess/coarsen.h"
#include "shared/preprocess/round_intervals.h"
#include "shared/preprocess/size_forecast.h"

namespace isosplat {

void BlockWorker::work(const Layer& layer, Index3 block, const CoarserLayer& coarser,
                       const SlabOptions& options, double most_bytes, SharedSlabs& slabs,
                       EncodedBlock& out) {
  gather_block(layer, block, block_);
  if (layer.grid.level > 0) round_intervals(block_);
  find_row_intervals(block_);
  if (coarser.voxels) coarsen_block(layer, block_, coarser);
  planner_.count(block_.intervals);
  if (layer.grid.level == 0) statistics.add_block(planner_, block_.intervals);
  out.interval = planner_.interval();
  const BlockView view{block_.cells, block_.voxels.data(), block_.intervals.data(),
                       layer.grid.level > 0, block_.row_intervals.data()};
  SlabOptions chosen = options;
  for (;; chosen.lambda = std::min(kMostLambda, 3 * chosen.lambda)) {
    out.lambda = chosen.lambda;
    out.slabs.clear();
    out.bytes.clear();
    const std::vector<uint32_t>& ends = planner_.plan(
        block_options(chosen, layer.grid.level, planner_.cells(), block_.intervals.size()));
    masks_.set(view, out.interval.min, ends);
    slabs.encode(encoder_, view, masks_, out.interval.min, ends, out.slabs, out.bytes);
    const bool fits = static_cast<double>(out.bytes.size()) <= most_bytes;
    if (fits || ends.size() <= 1 || chosen.lambda >= kMostLambda) return;
  }
}

}  // namespace isosplat
