#include "native/build/block_worker.h"

#include "native/build/coarsen.h"

namespace isosplat {

void BlockWorker::work(const Layer& layer, Index3 block, const CoarserLayer& coarser,
                       const SlabOptions& options, EncodedBlock& out) {
  gather_block(layer, block, block_);
  if (coarser.voxels) coarsen_block(layer, block_, coarser);
  planner_.count(block_.intervals);
  if (layer.grid.level == 0) statistics.add_block(planner_, block_.intervals);
  out.interval = planner_.interval();
  const BlockView view{block_.cells, block_.voxels.data(), block_.intervals.data(),
                       layer.grid.level > 0};
  uint32_t begin = out.interval.min;
  for (const uint32_t end : planner_.plan(options)) {
    const size_t before = out.bytes.size();
    const uint32_t cells = encoder_.encode(view, begin, end, out.bytes);
    out.slabs.push_back({end, cells, static_cast<uint32_t>(out.bytes.size() - before)});
    begin = end;
  }
}

}  // namespace isosplat
