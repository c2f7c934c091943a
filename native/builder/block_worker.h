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

/// One block's part of the store.
struct EncodedBlock {
  CellInterval interval;
  std::vector<BandChunk> bands;
  std::vector<std::byte> bytes;
  double storage_weight = 0;  ///< λ of the plan of its bands
};

/// Encodes blocks: gathers the cells of a block, computes its part of the coarser level, plans its
/// bands and encodes its chunks. One object per thread.
class BlockWorker {
 public:
  /// Encodes a block of the layer. Writes its part of `coarser`, unless `coarser.voxels` is null.
  /// While the chunks have more than `max_bytes`, the bands are planned again with a greater λ, up
  /// to kMaxStorageWeight.
  void encode(const Layer& layer, Index3 block, const CoarserLayer& coarser,
              const BandOptions& options, double max_bytes, SharedBands& bands, EncodedBlock& out);

  /// Encodes bands of other threads' blocks, when this thread has no block left.
  void help_others(SharedBands& bands) { bands.help(encoder_); }

  /// Of the encoded blocks of level 0. The builder adds the quantized values.
  VolumeStatistics statistics;

 private:
  GatheredBlock block_;
  BandPlanner planner_;
  BandMasks masks_;
  ChunkEncoder encoder_;
};

}  // namespace isosplat
