#pragma once

#include <vector>

#include "native/builder/shared_bands.h"
#include "shared/bands/band_planner.h"
#include "shared/codec/band_masks.h"
#include "shared/codec/chunk_codec.h"
#include "shared/preprocess/block_gather.h"
#include "shared/preprocess/layer.h"
#include "shared/preprocess/statistics.h"
#include "shared/store/store_writer.h"

namespace isosplat {

/// What a block adds to the store.
struct EncodedBlock {
  CellInterval interval;
  std::vector<BandChunk> bands;
  std::vector<std::byte> bytes;
  double storage_weight = 0;  ///< that of the volume's options with which it was cut
};

/// Everything that is done to one block: its cells, its part of the coarser level, its bands, its
/// chunks. One per thread.
class BlockWorker {
 public:
  /// Works on a block of the layer. Writes its part of `coarser`, where that has memory. A block
  /// of more than `max_bytes` is cut again with a greater λ, up to kMaxStorageWeight.
  void work(const Layer& layer, Index3 block, const CoarserLayer& coarser,
            const BandOptions& options, double max_bytes, SharedBands& bands, EncodedBlock& out);

  /// Once there is no block of the layer left: helps others with theirs.
  void help(SharedBands& bands) { bands.help(encoder_); }

  VolumeStatistics
      statistics;  ///< of the blocks of level 0, and of the quantized values given to it

 private:
  GatheredBlock block_;
  BandPlanner planner_;
  BandMasks masks_;
  ChunkEncoder encoder_;
};

}  // namespace isosplat
