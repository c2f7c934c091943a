#include "shared/core/builder/store_build.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "shared/core/builder/metadata.h"
#include "shared/core/builder/sample_volume.h"
#include "shared/core/builder/scan_volume.h"
#include "shared/core/preprocess/isovalue_guess.h"
#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

/// The least λ (weight of a stored byte) for a fetch weight of 1. The size limit may require a
/// greater one.
constexpr double kMinStorageWeight = 0.09;

/// If the store may exceed its size limit, at most a quarter of a level's blocks are encoded at the
/// same time, so that later blocks can adapt to the sizes of the first ones. This is the upper
/// limit of that number.
constexpr uint64_t kMaxBlocksInFlight = 64;

const char* phase_of(uint32_t level) {
  static constexpr const char* kPhases[] = {"level 0", "level 1", "level 2", "level 3", "level 4"};
  return kPhases[std::min<size_t>(level, std::size(kPhases) - 1)];
}

uint64_t product(Index3 n) {
  return static_cast<uint64_t>(n.x) * static_cast<uint64_t>(n.y) * static_cast<uint64_t>(n.z);
}

}  // namespace

StoreBuild::StoreBuild(VolumeSource& source, ByteSink& sink, const StoreOptions& options,
                       Executor& executor, unsigned encoders, SliceStorage* storage)
    : source_(source),
      sink_(sink),
      header_(source.header()),
      options_(options),
      executor_(executor),
      encoders_(encoders),
      storage_(storage),
      levels_(level_count(header_.grid.voxels)) {}

void StoreBuild::report(const char* phase, uint64_t voxels_done) {
  work_done_ += voxels_done;
  if (!options_.progress) return;
  const Clock::time_point now = Clock::now();
  if (now - last_report_ < std::chrono::milliseconds(50)) return;
  last_report_ = now;
  BuildProgress progress;
  progress.phase = phase;
  progress.fraction = static_cast<double>(work_done_) / static_cast<double>(work_total_);
  const double encoding = std::chrono::duration<double>(now - encoding_start_).count();
  if (work_done_ > range_work_ && encoding > 0) {
    const double done = static_cast<double>(work_done_ - range_work_);
    progress.voxels_per_second = done / encoding;
    progress.seconds_left =
        static_cast<double>(work_total_ - work_done_) / progress.voxels_per_second;
  }
  options_.progress(progress);
}

Result<void> StoreBuild::begin() {
  const Index3 n = header_.grid.voxels;
  auto writer = StoreWriter::create(n, metadata_limit(header_, options_), sink_);
  if (!writer) return tl::unexpected(writer.error());
  writer_.emplace(std::move(*writer));
  auto plan = plan_memory(header_, source_.resident_bytes(), source_.reads_rows(), encoders_,
                          storage_ != nullptr, options_.memory_bytes);
  if (!plan) return tl::unexpected(plan.error());
  plan_ = std::move(*plan);
  pending_.resize(levels_);
  if (options_.scan && options_.scan->type() != header_.type) {
    return fail(Status::invalid_argument, "expected a scan of volumes of this volume's type");
  }
  const bool reads_range = !options_.scan && scans_all(header_, options_.max_error);
  range_work_ = reads_range ? product(n) : 0;
  work_total_ = range_work_;
  for (uint32_t l = 0; l < levels_; ++l) work_total_ += product(level_grid(n, l).cells);

  std::shared_ptr<const VoxelScan> scan = options_.scan;
  if (!scan) {
    auto scanned = scan_volume(source_, executor_, reads_range, [&](uint64_t voxels) {
      report("reading the value range", reads_range ? voxels : 0);
    });
    if (!scanned) return tl::unexpected(scanned.error());
    scan = std::make_shared<const VoxelScan>(std::move(*scanned));
  }
  auto quantization = choose_quantization(header_, *scan, options_.max_error);
  if (!quantization) return tl::unexpected(quantization.error());
  quantization_ = std::move(*quantization);
  mapping_ = quantization_.mapping();
  if (options_.only_isovalue) {
    const float quantized = mapping_.quantized_isovalue(*options_.only_isovalue);
    only_isovalue_ = static_cast<QuantizedValue>(std::clamp(std::floor(quantized), 0.0f, 65534.0f));
  }
  reader_.emplace(source_, quantization_, executor_);
  if (auto created = create_budget(); !created) return created;
  encoding_start_ = Clock::now();
  return {};
}

uint64_t StoreBuild::key() const {
  StoreInfo info;
  info.grid = header_.grid;
  info.mapping = mapping_;
  // The metadata contain the options and the volume's properties.
  const std::string metadata = metadata_json(header_, options_, info, VolumeStatistics());
  const VolumeGrid& grid = header_.grid;
  const std::array numbers{static_cast<double>(grid.voxels.x),
                           static_cast<double>(grid.voxels.y),
                           static_cast<double>(grid.voxels.z),
                           mapping_.offset,
                           mapping_.scale,
                           mapping_.max_error,
                           static_cast<double>(mapping_.bits),
                           static_cast<double>(mapping_.has_missing),
                           options_.fetch_weight,
                           options_.max_error,
                           only_isovalue_ ? static_cast<double>(*only_isovalue_) : -1.0,
                           options_.coarse_levels ? 1.0 : 0.0};
  const std::array geometry{grid.spacing, grid.origin};
  const std::array parts{checksum64(std::as_bytes(std::span(metadata))),
                         checksum64(std::as_bytes(std::span(numbers))),
                         checksum64(std::as_bytes(std::span(geometry))),
                         checksum64(std::as_bytes(std::span(&grid.direction, 1))),
                         checksum64(std::as_bytes(std::span(isovalue_distribution_)))};
  return checksum64(std::as_bytes(std::span(parts)));
}

Result<void> StoreBuild::create_budget() {
  const auto sample = sample_volume(source_, quantization_, executor_);
  if (!sample) return tl::unexpected(sample.error());
  isovalue_distribution_ = guess_isovalues(sample->statistics, sample->voxels);
  if (only_isovalue_) {
    const auto above = isovalue_distribution_.begin() + *only_isovalue_ + 1;
    std::fill(isovalue_distribution_.begin(), above, 0.0);
    std::fill(above, isovalue_distribution_.end(), 1.0);
  }
  band_options_.isovalue_distribution = isovalue_distribution_;
  band_options_.storage_weight =
      std::min(kMinStorageWeight / options_.fetch_weight, kMaxStorageWeight);
  const Index3 n = header_.grid.voxels;
  const auto voxel_size = std::min<size_t>(voxel_bytes(header_.type), mapping_.bits / 8);
  const double max_bytes = double{1} * n.x * n.y * n.z * static_cast<double>(voxel_size) *
                           std::sqrt(options_.fetch_weight);
  max_bytes_ = static_cast<uint64_t>(max_bytes);
  std::vector<ColumnForecast> columns(sample->columns.size());
  std::vector<BandPlanner> planners(executor_.threads());
  executor_.run(columns.size(), [&](unsigned thread, size_t i) {
    columns[i] = forecast_column(sample->columns[i], band_options_, planners[thread]);
  });
  forecast_.emplace(*sample, n, band_options_, columns);
  budget_.emplace(*forecast_, max_bytes, static_cast<double>(writer_->bytes_written()));
  return {};
}

Result<std::unique_ptr<SliceStore>> StoreBuild::create_slices(uint32_t level, size_t item_bytes,
                                                              const LevelBox& all) {
  if (!plan_.in_memory[level]) return storage_->create(item_bytes, all);
  return std::make_unique<MemorySlices>(item_bytes, all);
}

Result<void> StoreBuild::begin_level() {
  const uint32_t coarser = layer_.grid.level + 1;
  coarser_ = {};
  if (coarser == levels_) return {};
  coarser_.grid = level_grid(header_.grid.voxels, coarser);
  const int32_t cells = coarser_.grid.cells.z;
  auto voxels =
      create_slices(coarser, mapping_.bits / 8u, voxel_slices(coarser_.grid, 0, cells + 1));
  if (!voxels) return tl::unexpected(voxels.error());
  auto intervals = create_slices(coarser, mapping_.bits / 4u, cell_slices(coarser_.grid, 0, cells));
  if (!intervals) return tl::unexpected(intervals.error());
  pending_[coarser] = {std::move(*voxels), std::move(*intervals)};
  return {};
}

Result<void> StoreBuild::end_band() {
  if (is_last_band()) output_.reset();
  layer_.voxels = layer_.intervals = nullptr;
  if (!coarser_.voxels) return {};
  PendingLevel& level = pending_[coarser_.grid.level];
  if (auto stored = level.voxels->commit(); !stored) return stored;
  return level.intervals->commit();
}

Layer StoreBuild::layer_of(uint32_t level) const {
  Layer layer{level_grid(header_.grid.voxels, level), mapping_.bits, mapping_.has_missing};
  layer.only_isovalue = only_isovalue_;
  layer.coarse_levels = options_.coarse_levels;
  return layer;
}

Result<bool> StoreBuild::next_layer() {
  auto advanced = advance_layer();
  if (!advanced || !*advanced) return advanced;
  if (auto loaded = load_layer(true); !loaded) return tl::unexpected(loaded.error());
  return true;
}

Result<bool> StoreBuild::advance_layer() {
  if (!output_) {
    layer_ = layer_of(0);
    begin_band(0);
  } else {
    if (auto ended = end_band(); !ended) return tl::unexpected(ended.error());
    if (!is_last_band()) {
      begin_band(band_.end);
    } else {
      if (++z_ == layer_.grid.blocks.z) {
        const uint32_t level = layer_.grid.level;
        pending_[level] = {};
        if (level == 0) reader_->release();
        if (level + 1 == levels_) return false;
        z_ = 0;
        layer_ = layer_of(level + 1);
      }
      begin_band(0);
    }
  }
  if (z_ == 0 && band_.first == 0) {
    if (auto begun = begin_level(); !begun) return tl::unexpected(begun.error());
  }
  set_boxes();
  const LevelGrid& grid = layer_.grid;
  if (grid.level + 1 < levels_) {
    PendingLevel& level = pending_[grid.level + 1];
    const auto voxels = level.voxels->prepare(coarser_.voxel_box);
    const auto intervals = level.intervals->prepare(coarser_.cell_box);
    coarser_.voxels = voxels.items;
    coarser_.voxel_box = voxels.box;
    coarser_.intervals = intervals.items;
    coarser_.cell_box = intervals.box;
  }
  if (!output_) {
    const bool is_limited = !budget_->is_ample();
    const uint64_t in_layer =
        static_cast<uint64_t>(grid.blocks.x) * static_cast<uint64_t>(grid.blocks.y);
    const uint64_t max_in_flight =
        is_limited ? std::clamp<uint64_t>(grid.block_count() / 4, 1, kMaxBlocksInFlight) : in_layer;
    output_.emplace(*writer_, *budget_, band_options_, grid, z_, static_cast<size_t>(max_in_flight),
                    is_limited);
  }
  output_->open_until(static_cast<size_t>(grid.blocks.x) * static_cast<size_t>(band_.end));
  return true;
}

void StoreBuild::begin_band(int32_t first) {
  band_ = band_at(layer_.grid, first, plan_.band_rows[layer_.grid.level]);
}

void StoreBuild::set_boxes() {
  const LevelGrid& grid = layer_.grid;
  layer_.voxel_box = band_voxels(grid, z_, band_);
  const Index3 first{0, band_.first * kBlockCells, z_ * kBlockCells};
  const Index3 end{grid.cells.x, std::min(band_.end * kBlockCells, grid.cells.y),
                   std::min(first.z + kBlockCells, grid.cells.z)};
  layer_.cell_box = {first, {end.x, end.y - first.y, end.z - first.z}};
  if (grid.level + 1 == levels_) return;
  const Index3 coarse{0, first.y / 2, first.z / 2};
  const Index3 cells{coarser_.grid.cells.x, (end.y + 1) / 2 - coarse.y, (end.z + 1) / 2 - coarse.z};
  coarser_.cell_box = {coarse, cells};
  // The last blocks of an axis also write the last voxel.
  coarser_.voxel_box = {coarse,
                        {cells.x + 1, cells.y + (is_last_band() ? 1 : 0),
                         cells.z + (z_ + 1 == grid.blocks.z ? 1 : 0)}};
}

Result<void> StoreBuild::load_layer(bool counts_values) {
  if (layer_.voxels) return {};
  if (layer_.grid.level == 0) return read_band(counts_values ? band_ : BlockRows());
  return load_coarse_band();
}

Result<void> StoreBuild::read_band(BlockRows counted) {
  const auto voxels = reader_->read(z_, band_, counted);
  if (!voxels) return tl::unexpected(voxels.error());
  layer_.voxels = *voxels;
  return {};
}

Result<void> StoreBuild::load_coarse_band() {
  PendingLevel& level = pending_[layer_.grid.level];
  const auto voxels = level.voxels->load(layer_.voxel_box);
  if (!voxels) return tl::unexpected(voxels.error());
  const auto intervals = level.intervals->load(layer_.cell_box);
  if (!intervals) return tl::unexpected(intervals.error());
  layer_.voxels = voxels->items;
  layer_.voxel_box = voxels->box;
  layer_.intervals = intervals->items;
  layer_.cell_box = intervals->box;
  return {};
}

Result<void> StoreBuild::begin_part_band(int32_t z, BlockRows band, BlockRows counted) {
  z_ = z;
  layer_ = layer_of(0);
  band_ = band;
  coarser_ = {};
  if (levels_ > 1) coarser_.grid = level_grid(header_.grid.voxels, 1);
  set_boxes();
  if (levels_ > 1) {
    make_room(part_voxels_, coarser_.voxel_box.count() * (mapping_.bits / 8u));
    make_room(part_intervals_, coarser_.cell_box.count() * (mapping_.bits / 4u));
    coarser_.voxels = part_voxels_.data();
    coarser_.intervals = part_intervals_.data();
  }
  return read_band(counted);
}

BlockTask StoreBuild::part_task(size_t number) const {
  const auto n = static_cast<int32_t>(number);
  BlockTask task;
  task.number = number;
  task.index = {n % layer_.grid.blocks.x, n / layer_.grid.blocks.x, z_};
  task.options = band_options_;
  task.options.storage_weight = budget_->grant().storage_weight;
  return task;
}

void StoreBuild::report_part(size_t done, size_t blocks) {
  const uint64_t cells = product(layer_.grid.cells);
  work_total_ = range_work_ + cells;
  const double share = static_cast<double>(done) / static_cast<double>(blocks);
  work_done_ = range_work_ + static_cast<uint64_t>(share * static_cast<double>(cells));
  report("level 0", 0);
}

Result<void> StoreBuild::add_block(size_t number, EncodedBlock&& encoded) {
  const Index3 blocks = layer_.grid.blocks;
  const auto n = static_cast<int32_t>(number);
  const Index3 cells = block_cells(layer_.grid, {n % blocks.x, n / blocks.x, z_});
  if (auto added = output_->add(number, std::move(encoded)); !added) return added;
  report(phase_of(layer_.grid.level), product(cells));
  return {};
}

Result<BuildReport> StoreBuild::finish(const VolumeStatistics& of_cells) {
  VolumeStatistics statistics = of_cells;
  reader_->take_values(statistics);
  StoreInfo info;
  info.grid = header_.grid;
  info.mapping = mapping_;
  info.range = statistics.range();
  info.missing_voxels = statistics.missing();
  info.metadata = metadata_json(header_, options_, info, statistics);
  auto finished = writer_->finish(info);
  if (!finished) return tl::unexpected(finished.error());
  BuildReport report;
  report.info = std::move(*finished);
  report.raw_bytes = product(header_.grid.voxels) * voxel_bytes(header_.type);
  report.max_bytes = max_bytes_;
  report.needed_bytes = plan_.bytes;
  for (uint32_t l = 1; l < levels_; ++l) report.uses_temporary_files |= !plan_.in_memory[l];
  report.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  return report;
}

}  // namespace isosplat
