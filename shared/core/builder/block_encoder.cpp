#include "shared/core/builder/block_encoder.h"

#include <algorithm>

#include "shared/core/preprocess/block_storage_weight.h"
#include "shared/core/preprocess/coarse_levels.h"
#include "shared/core/preprocess/coarsen.h"
#include "shared/core/preprocess/round_intervals.h"
#include "shared/core/preprocess/size_forecast.h"

namespace isosplat {

BandChunk encode_band(ChunkEncoder& encoder, const BlockVoxels& voxels, const CellMask& mask,
                      uint32_t begin, uint32_t end, std::vector<std::byte>& bytes) {
  const size_t before = bytes.size();
  const uint32_t cells = encoder.encode(voxels, mask, begin, end, bytes);
  return {end, cells, static_cast<uint32_t>(bytes.size() - before)};
}

void BandsEncoder::encode(ChunkEncoder& encoder, const BlockVoxels& voxels, const BandMasks& masks,
                          uint32_t begin, std::span<const uint32_t> ends,
                          std::vector<BandChunk>& bands, std::vector<std::byte>& bytes) {
  for (size_t band = 0; band < ends.size(); begin = ends[band++]) {
    bands.push_back(encode_band(encoder, voxels, masks[band], begin, ends[band], bytes));
  }
}

bool is_result_of(const EncodedBlock& encoded, const BlockTask& task) {
  if (encoded.task_weight != task.options.storage_weight) return false;
  if (encoded.max_bytes == task.max_bytes) return true;
  // The first plan is the same. It is kept if its chunks fit, or if no other plan is tried.
  return encoded.storage_weight == encoded.task_weight &&
         (static_cast<double>(encoded.bytes.size()) <= task.max_bytes ||
          encoded.bands.size() <= 1 || encoded.storage_weight >= kMaxStorageWeight);
}

void BlockEncoder::encode(const Layer& layer, const CoarserLayer& coarser, const BlockTask& task,
                          BandsEncoder& bands, EncodedBlock& out) {
  gather_block(layer, task.index, block_);
  const CoarseLevels* const levels = layer.coarse_levels;
  if (layer.grid.level > 0) {
    levels ? levels->set_intervals(layer, block_) : round_intervals(block_);
  }
  find_row_intervals(block_);
  if (coarser.voxels) coarsen_block(layer, block_, coarser);
  planner_.count(block_.intervals);
  if (layer.grid.level == 0 && !task.is_counted) statistics.add_block(planner_, block_);
  out.interval = planner_.interval();
  const BlockVoxels voxels{block_.cells,
                           block_.voxels.data(),
                           block_.intervals.data(),
                           layer.grid.level > 0,
                           block_.row_intervals.data(),
                           layer.grid.level > 0 && levels && levels->corners_suffice()};
  out.task_weight = task.options.storage_weight;
  out.max_bytes = task.max_bytes;
  BandOptions chosen = task.options;
  for (;; chosen.storage_weight = std::min(kMaxStorageWeight, 3 * chosen.storage_weight)) {
    out.storage_weight = chosen.storage_weight;
    out.bands.clear();
    out.bytes.clear();
    const std::vector<uint32_t>& ends = planner_.plan(
        block_options(chosen, layer.grid.level, planner_.cells(), block_.intervals.size()));
    masks_.set(voxels, out.interval.min, ends);
    bands.encode(encoder_, voxels, masks_, out.interval.min, ends, out.bands, out.bytes);
    const bool fits = static_cast<double>(out.bytes.size()) <= task.max_bytes;
    if (fits || ends.size() <= 1 || chosen.storage_weight >= kMaxStorageWeight) return;
  }
}

}  // namespace isosplat
