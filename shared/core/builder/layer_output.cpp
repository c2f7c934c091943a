#include "shared/core/builder/layer_output.h"

#include <algorithm>

#include "shared/core/store/format.h"

namespace isosplat {

LayerOutput::LayerOutput(StoreWriter& writer, SizeBudget& budget, const BandOptions& options,
                         const LevelGrid& grid, int32_t z, size_t max_in_flight, bool is_limited)
    : writer_(writer),
      budget_(budget),
      options_(options),
      grid_(grid),
      z_(z),
      max_in_flight_(max_in_flight),
      is_limited_(is_limited),
      ready_(static_cast<size_t>(grid.blocks.x) * static_cast<size_t>(grid.blocks.y)) {
  grants_.push_back(budget.grant());
}

Index3 LayerOutput::index_of(size_t number) const {
  const auto n = static_cast<int32_t>(number);
  return {n % grid_.blocks.x, n / grid_.blocks.x, z_};
}

std::optional<BlockTask> LayerOutput::begin_block() {
  if (is_begun()) return std::nullopt;
  const size_t needed = begun_ + 1 > max_in_flight_ ? begun_ + 1 - max_in_flight_ : 0;
  if (written_ < needed) return std::nullopt;
  const SizeBudget::Grant& grant = grants_[needed];
  BlockTask task;
  task.number = begun_++;
  task.index = index_of(task.number);
  task.options = options_;
  task.options.storage_weight = grant.storage_weight;
  if (is_limited_) {
    task.max_bytes = budget_.min_bytes(grant, grid_.level, task.index) +
                     std::max(grant.slack, 0.0) / static_cast<double>(max_in_flight_);
  }
  return task;
}

Result<void> LayerOutput::add(size_t number, EncodedBlock&& encoded) {
  ready_[number] = std::move(encoded);
  for (; written_ < ready_.size() && ready_[written_]; ++written_) {
    const EncodedBlock& first = *ready_[written_];
    auto written = writer_.add_block(first.interval, first.bands, first.bytes);
    if (!written) return written;
    const size_t records = kBlockRecordBytes + kChunkRecordBytes * first.bands.size();
    budget_.add(grid_.level, index_of(written_), first.storage_weight,
                static_cast<double>(first.bytes.size() + records));
    grants_.push_back(budget_.grant());
    ready_[written_].reset();
  }
  return {};
}

}  // namespace isosplat
