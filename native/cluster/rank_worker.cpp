#include "native/cluster/rank_worker.h"

#include <algorithm>
#include <utility>

#include "native/builder/refusals.h"
#include "native/cluster/rank_pause.h"
#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/memory_plan.h"
#include "shared/core/builder/scan_volume.h"

namespace isosplat {

RankWorker::RankWorker(VolumeSource& source, const BuildOptions& options, Transport& transport)
    : source_(source),
      options_(options),
      transport_(transport),
      executor_(thread_count(options)),
      grid_(level_grid(source.header().grid.voxels, 0)) {}

RankWorker::~RankWorker() {
  stop();
}

void RankWorker::stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
    work_.notify_all();
  }
  threads_.clear();
}

Result<void> RankWorker::handle(Message&& message) {
  return with_refusals([&]() -> Result<void> {
    if (message.kind == MessageKind::scan) {
      ScanOrder order;
      return unpack(message.content, order) ? scan(order) : malformed_message();
    }
    if (message.kind == MessageKind::quantize) return quantize(message.content);
    if (message.kind == MessageKind::begin) {
      begin(message.content);
      return {};
    }
    const std::lock_guard lock(mutex_);
    if (message.kind == MessageKind::task) {
      tasks_.push_back(std::move(message.content));
      work_.notify_all();
      return {};
    }
    TaskOrder order;
    const size_t in_layer =
        static_cast<size_t>(grid_.blocks.x) * static_cast<size_t>(grid_.blocks.y);
    const bool is_order = message.kind == MessageKind::order && unpack(message.content, order) &&
                          order.number < in_layer && order.z >= 0 && order.z < grid_.blocks.z &&
                          order.encoder >= 0 && order.encoder < transport_.ranks();
    if (!is_order) return malformed_message();
    orders_.push_back(order);
    return {};
  });
}

Result<void> RankWorker::scan(const ScanOrder& order) {
  const int32_t slices = source_.header().grid.voxels.z;
  if (order.first < 0 || order.first > order.end || order.end > slices) return malformed_message();
  const auto scan = scan_slices(source_, executor_, order.first, order.end, true, [](uint64_t) {});
  if (!scan) return tl::unexpected(scan.error());
  transport_.send(0, MessageKind::scanned, scan->bytes());
  return {};
}

Result<void> RankWorker::quantize(std::span<const std::byte> scan_message) {
  VoxelScan scan(source_.header().type);
  if (auto added = scan.add_message(scan_message); !added) return added;
  auto quantization = choose_quantization(source_.header(), scan, options_.max_error);
  if (!quantization) return tl::unexpected(quantization.error());
  quantization_ = std::move(*quantization);
  auto plan = plan_memory(source_.header(), source_.resident_bytes(), source_.reads_rows(),
                          executor_.threads() + kMessageEncoders, true, options_.memory_bytes);
  if (!plan) return tl::unexpected(plan.error());
  band_rows_ = plan->band_rows[0];
  reader_.emplace(source_, quantization_, executor_);
  threads_.emplace_back([this] { read_layers(); });
  return {};
}

void RankWorker::begin(std::span<const std::byte> distribution) {
  isovalue_distribution_ = numbers_of<double>(distribution);
  encoders_ = std::vector<BlockEncoder>(executor_.threads());
  for (BlockEncoder& encoder : encoders_) {
    threads_.emplace_back([this, &encoder] { encode_tasks(encoder); });
  }
}

void RankWorker::fail_with(const Error& error) {
  const std::lock_guard lock(mutex_);
  if (!error_) error_ = error;
  is_stopping_ = true;
  work_.notify_all();
  news_.notify_all();
}

void RankWorker::read_layers() {
  for (int32_t z = 0; z < grid_.blocks.z; ++z) {
    if (layer_reader_of(z, transport_.ranks()) != transport_.rank()) continue;
    for (int32_t y = 0; y < grid_.blocks.y; y += band_rows_) {
      if (!read_band(z, band_at(grid_, y, band_rows_))) return;
    }
  }
  reader_->release();
}

bool RankWorker::read_band(int32_t z, BlockRows band) {
  const auto voxels = with_refusals([&] { return reader_->read(z, band, band); });
  if (!voxels) {
    fail_with(voxels.error());
    return false;
  }
  std::unique_lock lock(mutex_);
  layer_ = {grid_, quantization_.mapping().bits, quantization_.mapping().has_missing};
  layer_.voxels = *voxels;
  layer_.voxel_box = band_voxels(grid_, z, band);
  layer_z_ = z;
  band_ = band;
  open_tasks_ = static_cast<size_t>(grid_.blocks.x) * static_cast<size_t>(band.count());
  news_.notify_all();
  work_.wait(lock, [&] { return is_stopping_ || open_tasks_ == 0; });
  return !is_stopping_;
}

bool RankWorker::has_voxels_of_next() const {
  if (orders_.empty() || !layer_.voxels) return false;
  const TaskOrder& next = orders_.front();
  const auto row = static_cast<int32_t>(next.number) / grid_.blocks.x;
  return next.z == layer_z_ && row >= band_.first && row < band_.end;
}

void RankWorker::encode_tasks(BlockEncoder& encoder) {
  std::unique_lock lock(mutex_);
  for (;;) {
    work_.wait(lock, [&] { return is_stopping_ || !tasks_.empty(); });
    if (is_stopping_) return;
    const std::vector<std::byte> task = std::move(tasks_.front());
    tasks_.pop_front();
    ++encoding_;
    lock.unlock();
    std::vector<std::byte> message;
    const auto encoded =
        with_refusals([&] { return encode_task(task, isovalue_distribution_, encoder, message); });
    if (!encoded) return fail_with(encoded.error());
    lock.lock();
    --encoding_;
    encoded_.push_back(std::move(message));
    news_.notify_all();
  }
}

Result<bool> RankWorker::send_finished() {
  std::deque<std::vector<std::byte>> encoded;
  std::vector<TaskOrder> orders;
  {
    const std::lock_guard lock(mutex_);
    if (error_) return tl::unexpected(*error_);
    encoded.swap(encoded_);
    while (has_voxels_of_next()) {
      orders.push_back(orders_.front());
      orders_.pop_front();
    }
  }
  for (auto& message : encoded) {
    transport_.send(0, MessageKind::encoded, std::move(message));
  }
  // Tasks say only whether there is a coarser level.
  std::byte coarse_voxel{};
  CoarserLayer coarser;
  const Index3 volume = source_.header().grid.voxels;
  if (level_count(volume) > 1) coarser.voxels = &coarse_voxel;
  for (const TaskOrder& order : orders) {
    // The reading thread leaves the layer as it is until all of its tasks were sent.
    std::vector<std::byte> message;
    write_task(layer_, coarser, task_of(order, grid_.blocks.x), volume, message);
    transport_.send(order.encoder, MessageKind::task, std::move(message));
  }
  if (!orders.empty()) {
    const std::lock_guard lock(mutex_);
    open_tasks_ -= std::min(open_tasks_, orders.size());
    if (open_tasks_ == 0) layer_.voxels = nullptr;
    work_.notify_all();
  }
  return !encoded.empty() || !orders.empty();
}

void RankWorker::wait() {
  std::unique_lock lock(mutex_);
  const bool is_idle = tasks_.empty() && encoding_ == 0;
  const auto at_most = is_idle ? kShortPause : pause_of(transport_);
  news_.wait_for(lock, at_most,
                 [&] { return error_ || !encoded_.empty() || has_voxels_of_next(); });
}

VolumeStatistics RankWorker::statistics() {
  stop();
  VolumeStatistics statistics;
  if (reader_) reader_->take_values(statistics);
  for (const BlockEncoder& encoder : encoders_) statistics.add(encoder.statistics);
  return statistics;
}

}  // namespace isosplat
