#pragma once

#include <vector>

#include "native/builder/shared_slabs.h"
#include "shared/codec/chunk_codec.h"
#include "shared/codec/slab_masks.h"
#include "shared/preprocess/block_gather.h"
#include "shared/preprocess/layer.h"
#include "shared/preprocess/statistics.h"
#include "shared/slabs/slab_planner.h"
#include "shared/store/store_writer.h"

namespace isosplat {

/// What a block adds to the store.
struct EncodedBlock {
  CellInterval interval;
  std::vector<SlabChunk> slabs;
  std::vector<std::byte> bytes;
  double lambda = 0;  ///< that of the volume's options with which it was cut
};

/// Everything that is done to one block: its cells, its part of the coarser level, its slabs, its
/// chunks. One per thread.
class BlockWorker {
 public:
  /// Works on a block of the layer. Writes its part of `coarser`, where that has memory. A block
  /// of more than `most_bytes` is cut again with a greater λ, up to kMostLambda.
  void work(const Layer& layer, Index3 block, const CoarserLayer& coarser,
            const SlabOptions& options, double most_bytes, SharedSlabs& slabs, EncodedBlock& out);

  /// Once there is no block of the layer left: helps others with theirs.
  void help(SharedSlabs& slabs) { slabs.help(encoder_); }

  VolumeStatistics statistics;  ///< of the blocks of level 0, and of the codes given to it

 private:
  GatheredBlock block_;
  SlabPlanner planner_;
  SlabMasks masks_;
  ChunkEncoder encoder_;
};

}  // namespace isosplat
