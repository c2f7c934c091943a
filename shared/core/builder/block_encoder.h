#pragma once

#include <limits>
#include <vector>

#include "shared/core/bands/band_planner.h"
#include "shared/core/codec/band_masks.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/preprocess/block_gather.h"
#include "shared/core/preprocess/layer.h"
#include "shared/core/preprocess/statistics.h"
#include "shared/core/store/store_writer.h"

namespace isosplat {

/// A block to encode, and the limits of its size.
struct BlockTask {
  size_t number = 0;  ///< in its layer of blocks, in raster order
  Index3 index;       ///< in its level
  BandOptions options;
  /// While the chunks have more bytes, the bands are planned again with a greater λ.
  double max_bytes = std::numeric_limits<double>::infinity();
  bool is_counted = false;  ///< whether the statistics of its cells are known already
};

/// One block's part of the store.
struct EncodedBlock {
  CellInterval interval;
  std::vector<BandChunk> bands;
  std::vector<std::byte> bytes;
  double storage_weight = 0;  ///< λ of the plan of its bands
  double task_weight = 0;     ///< λ of the task; storage_weight is greater if it did not fit
  double max_bytes = 0;       ///< of the task
};

/// Whether encoding the block of a task gives `encoded`, which was encoded from the same voxels,
/// perhaps with another λ or size limit.
bool is_result_of(const EncodedBlock& encoded, const BlockTask& task);

/// Encodes the bands of a block. Other implementations share the bands among threads.
class BandsEncoder {
 public:
  virtual ~BandsEncoder() = default;

  /// Encodes the bands of a block and appends them to `bands` and `bytes`, in order. Band i is the
  /// half-open interval [ends[i − 1], ends[i]), the first one [begin, ends[0]). `masks`: the cells
  /// of each band.
  virtual void encode(ChunkEncoder& encoder, const BlockVoxels& voxels, const BandMasks& masks,
                      uint32_t begin, std::span<const uint32_t> ends, std::vector<BandChunk>& bands,
                      std::vector<std::byte>& bytes);
};

/// Encodes one band and appends its chunk to `bytes`. See BandsEncoder::encode.
BandChunk encode_band(ChunkEncoder& encoder, const BlockVoxels& voxels, const CellMask& mask,
                      uint32_t begin, uint32_t end, std::vector<std::byte>& bytes);

/// Encodes blocks: gathers the cells of a block, computes its part of the coarser level, plans its
/// bands and encodes its chunks. One object per thread.
class BlockEncoder {
 public:
  /// Encodes a block of the layer. Writes its part of `coarser`, unless `coarser.voxels` is null.
  /// The bands are not planned with a greater λ than kMaxStorageWeight. `statistics` do not count a
  /// task that is_counted.
  void encode(const Layer& layer, const CoarserLayer& coarser, const BlockTask& task,
              BandsEncoder& bands, EncodedBlock& out);

  /// For BandsEncoder::encode, when this thread does not encode a block itself.
  ChunkEncoder& chunk_encoder() { return encoder_; }

  /// The statistics of the cells of the encoded blocks of level 0. They count no quantized values.
  VolumeStatistics statistics;

 private:
  GatheredBlock block_;
  BandPlanner planner_;
  BandMasks masks_;
  ChunkEncoder encoder_;
};

}  // namespace isosplat
