#include "native/builder/builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>

#include "native/builder/memory_plan.h"
#include "native/builder/metadata.h"
#include "native/builder/ordered_output.h"
#include "native/builder/parallel.h"
#include "native/builder/quantized_reader.h"
#include "native/builder/sample_volume.h"
#include "native/builder/scan_volume.h"
#include "native/builder/slice_store.h"
#include "native/files/output_file.h"
#include "shared/preprocess/isovalue_guess.h"
#include "shared/preprocess/quantization.h"
#include "shared/preprocess/size_budget.h"
#include "shared/store/format.h"

namespace isosplat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// λ, the weight of a stored byte, at a fetch weight of 1, if the size limit does not require more.
constexpr double kMinStorageWeight = 0.09;

/// Upper limit of the blocks that are encoded at a time if the store may exceed its size limit. The
/// limit is a quarter of the level's blocks, so that later blocks can adapt to the sizes of the
/// first ones, but at most this number.
constexpr uint64_t kMaxBlocksInFlight = 64;

/// Voxels and intervals of a coarse level, from their computation until the level is encoded.
struct PendingLevel {
  SliceStore voxels, intervals;
};

class Builder {
 public:
  Builder(VolumeSource& source, const BuildOptions& options)
      : source_(source),
        header_(source.header()),
        options_(options),
        threads_(options.threads > 0 ? options.threads
                                     : std::max(1u, std::thread::hardware_concurrency())) {}

  Result<BuildReport> build(ByteSink& sink);

 private:
  Result<void> build_level(uint32_t level, StoreWriter& writer);
  Result<void> build_layer(const Layer& layer, int32_t z, const CoarserLayer& coarser,
                           StoreWriter& writer);
  /// Sets the layer's slices of the cells [first_cell, end_cell), of level 0: reads them from the
  /// source.
  Result<void> read_layer(Layer& layer, int32_t first_cell, int32_t end_cell);
  /// The same for a coarse level, from memory or its temporary file.
  Result<void> load_layer(Layer& layer, int32_t first_cell, int32_t end_cell);
  Result<void> create_pending_level(uint32_t level);
  Result<void> create_budget(uint64_t header_bytes);
  void report(const char* phase, uint64_t voxels_done);

  VolumeSource& source_;
  const VolumeHeader& header_;
  const BuildOptions& options_;
  const unsigned threads_;
  MemoryPlan plan_;
  Quantization quantization_;
  ValueMapping mapping_;
  BandOptions band_options_;
  std::vector<double> isovalue_distribution_;
  uint64_t max_bytes_ = 0;  // of the store
  std::optional<SizeForecast> forecast_;
  std::optional<SizeBudget> budget_;
  std::vector<BlockWorker> workers_;
  std::optional<QuantizedReader> reader_;
  std::vector<std::optional<PendingLevel>> pending_levels_;  // per level
  std::vector<std::byte> layer_buffer_;  // level 0: a layer's slices, and the slice before it
  Clock::time_point start_ = Clock::now(), encoding_start_ = start_, last_report_ = start_;
  uint64_t work_total_ = 0;  // voxels of all levels, and of reading the range
  uint64_t work_done_ = 0, range_work_ = 0;
  std::mutex report_mutex_;
};

void Builder::report(const char* phase, uint64_t voxels_done) {
  const std::lock_guard lock(report_mutex_);
  work_done_ += voxels_done;
  if (!options_.progress) return;
  const Clock::time_point now = Clock::now();
  if (now - last_report_ < std::chrono::milliseconds(50)) return;
  last_report_ = now;
  BuildProgress progress;
  progress.phase = phase;
  progress.fraction = static_cast<double>(work_done_) / static_cast<double>(work_total_);
  const double encoding = seconds_since(encoding_start_);
  if (work_done_ > range_work_ && encoding > 0) {
    const double done = static_cast<double>(work_done_ - range_work_);
    progress.voxels_per_second = done / encoding;
    progress.seconds_left =
        static_cast<double>(work_total_ - work_done_) / progress.voxels_per_second;
  }
  options_.progress(progress);
}

Result<void> Builder::create_pending_level(uint32_t level) {
  const LevelGrid grid = level_grid(header_.grid.voxels, level);
  const bool in_memory = plan_.in_memory[level];
  const std::filesystem::path folder = options_.temporary_folder.empty()
                                           ? std::filesystem::temp_directory_path()
                                           : options_.temporary_folder;
  auto voxels = SliceStore::create(voxel_slice_bytes(grid, mapping_.bits), grid.cells.z + 1,
                                   in_memory, folder);
  if (!voxels) return tl::unexpected(voxels.error());
  auto intervals = SliceStore::create(interval_slice_bytes(grid, mapping_.bits), grid.cells.z,
                                      in_memory, folder);
  if (!intervals) return tl::unexpected(intervals.error());
  pending_levels_[level].emplace(PendingLevel{std::move(*voxels), std::move(*intervals)});
  return {};
}

Result<void> Builder::build_layer(const Layer& layer, int32_t z, const CoarserLayer& coarser,
                                  StoreWriter& writer) {
  const Index3 blocks = layer.grid.blocks;
  const size_t count = static_cast<size_t>(blocks.x) * static_cast<size_t>(blocks.y);
  static constexpr const char* kPhases[] = {"level 0", "level 1", "level 2", "level 3", "level 4"};
  const char* phase = kPhases[std::min<size_t>(layer.grid.level, std::size(kPhases) - 1)];
  const bool is_limited = !budget_->is_ample();
  const size_t max_in_flight =
      is_limited ? std::clamp<size_t>(layer.grid.block_count() / 4, 1, kMaxBlocksInFlight) : count;
  OrderedOutput output(writer, *budget_, layer.grid, z, max_in_flight);
  SharedBands bands(threads_);
  std::atomic<size_t> next{0};
  std::atomic<bool> has_thrown{false};
  on_threads(threads_, [&](unsigned thread) {
    try {
      for (size_t i = next++; i < count && !has_thrown && !output.has_failed(); i = next++) {
        const Index3 index = output.index_of(i);
        const auto grant = output.grant(i);
        if (!grant) break;
        BandOptions options = band_options_;
        options.storage_weight = grant->storage_weight;
        double max_bytes = std::numeric_limits<double>::infinity();
        if (is_limited) {
          max_bytes = budget_->min_bytes(*grant, layer.grid.level, index) +
                      std::max(grant->slack, 0.0) / static_cast<double>(max_in_flight);
        }
        EncodedBlock encoded;
        workers_[thread].encode(layer, index, coarser, options, max_bytes, bands, encoded);
        output.add(i, std::move(encoded));
        const Index3 cells = block_cells(layer.grid, index);
        report(phase, static_cast<uint64_t>(cells.x) * static_cast<uint64_t>(cells.y) *
                          static_cast<uint64_t>(cells.z));
      }
    } catch (...) {
      has_thrown = true;
      output.stop();  // other threads may wait there for this thread's block
      workers_[thread].help_others(bands);
      throw;
    }
    workers_[thread].help_others(bands);
  });
  return output.result();
}

Result<void> Builder::read_layer(Layer& layer, int32_t first_cell, int32_t end_cell) {
  const size_t slice = voxel_slice_bytes(layer.grid, mapping_.bits);
  const int32_t first_voxel = std::max(first_cell - 1, 0);
  std::vector<std::byte>& buffer = layer_buffer_;
  if (first_cell == 0) {
    buffer.resize(slice * static_cast<size_t>(std::min(kBlockCells + 2, layer.grid.cells.z + 1)));
  }
  // Layers overlap: the last two slices of the layer before are the first of this one.
  const int32_t read_end = first_cell == 0 ? 0 : first_cell + 1;
  const auto kept = static_cast<size_t>(read_end - first_voxel);
  if (first_cell > 0) {
    const auto buffered = static_cast<size_t>(read_end - layer.first_voxel_slice);
    std::copy_n(buffer.data() + slice * (buffered - kept), slice * kept, buffer.data());
  }
  const auto count_values = [this](unsigned thread, const std::byte* quantized_values,
                                   size_t voxels) {
    workers_[thread].statistics.add_values(quantized_values, voxels, mapping_.bits,
                                           mapping_.has_missing);
  };
  auto read =
      reader_->read(read_end, end_cell + 1 - read_end, buffer.data() + slice * kept, count_values);
  layer.voxels = buffer.data();
  layer.first_voxel_slice = first_voxel;
  return read;
}

Result<void> Builder::load_layer(Layer& layer, int32_t first_cell, int32_t end_cell) {
  PendingLevel& level = *pending_levels_[layer.grid.level];
  layer.first_voxel_slice = std::max(first_cell - 1, 0);
  layer.first_cell_slice = first_cell;
  auto voxels = level.voxels.load(layer.first_voxel_slice, end_cell + 1 - layer.first_voxel_slice);
  if (!voxels) return tl::unexpected(voxels.error());
  auto intervals = level.intervals.load(first_cell, end_cell - first_cell);
  if (!intervals) return tl::unexpected(intervals.error());
  layer.voxels = *voxels;
  layer.intervals = *intervals;
  return {};
}

Result<void> Builder::build_level(uint32_t level, StoreWriter& writer) {
  Layer layer;
  layer.grid = level_grid(header_.grid.voxels, level);
  layer.bits = mapping_.bits;
  layer.has_missing = mapping_.has_missing;
  const bool has_coarser = level + 1 < pending_levels_.size();
  CoarserLayer coarser;
  if (has_coarser) {
    coarser.grid = level_grid(header_.grid.voxels, level + 1);
    if (auto created = create_pending_level(level + 1); !created) return created;
  }

  for (int32_t z = 0; z < layer.grid.blocks.z; ++z) {
    const int32_t first_cell = z * kBlockCells;
    const int32_t end_cell = std::min(first_cell + kBlockCells, layer.grid.cells.z);
    auto loaded = level == 0 ? read_layer(layer, first_cell, end_cell)
                             : load_layer(layer, first_cell, end_cell);
    if (!loaded) return loaded;
    if (has_coarser) {
      const int32_t first = first_cell / 2, count = (end_cell - first_cell + 1) / 2;
      const bool is_last = z + 1 == layer.grid.blocks.z;
      coarser.first_voxel_slice = coarser.first_cell_slice = first;
      coarser.voxels = pending_levels_[level + 1]->voxels.prepare(first, count + (is_last ? 1 : 0));
      coarser.intervals = pending_levels_[level + 1]->intervals.prepare(first, count);
    }
    if (auto built = build_layer(layer, z, coarser, writer); !built) return built;
    if (has_coarser) {
      if (auto stored = pending_levels_[level + 1]->voxels.commit(); !stored) return stored;
      if (auto stored = pending_levels_[level + 1]->intervals.commit(); !stored) return stored;
    }
  }
  pending_levels_[level].reset();
  layer_buffer_ = {};
  return {};
}

Result<void> Builder::create_budget(uint64_t header_bytes) {
  const auto sample = sample_volume(source_, quantization_, threads_);
  if (!sample) return tl::unexpected(sample.error());
  isovalue_distribution_ = guess_isovalues(sample->statistics, sample->voxels);
  band_options_.isovalue_distribution = isovalue_distribution_;
  band_options_.storage_weight =
      std::min(kMinStorageWeight / options_.fetch_weight, kMaxStorageWeight);
  const Index3 n = header_.grid.voxels;
  const auto voxel_size = std::min<size_t>(voxel_bytes(header_.type), mapping_.bits / 8);
  const double max_bytes = double{1} * n.x * n.y * n.z * static_cast<double>(voxel_size) *
                           std::sqrt(options_.fetch_weight);
  max_bytes_ = static_cast<uint64_t>(max_bytes);
  std::vector<ColumnForecast> columns(sample->columns.size());
  std::vector<BandPlanner> planners(threads_);
  parallel_for(threads_, columns.size(), [&](unsigned thread, size_t i) {
    columns[i] = forecast_column(sample->columns[i], band_options_, planners[thread]);
  });
  forecast_.emplace(*sample, n, band_options_, columns);
  budget_.emplace(*forecast_, max_bytes, static_cast<double>(header_bytes));
  return {};
}

Result<BuildReport> Builder::build(ByteSink& sink) {
  const Index3 n = header_.grid.voxels;
  auto writer = StoreWriter::create(n, metadata_limit(header_, options_), sink);
  if (!writer) return tl::unexpected(writer.error());
  auto plan = plan_memory(header_, source_.resident_bytes(), threads_, options_.memory_bytes);
  if (!plan) return tl::unexpected(plan.error());
  plan_ = std::move(*plan);
  const uint32_t levels = level_count(n);
  pending_levels_.resize(levels);
  workers_.resize(threads_);
  const uint64_t volume =
      static_cast<uint64_t>(n.x) * static_cast<uint64_t>(n.y) * static_cast<uint64_t>(n.z);
  // The quantization of integers of up to 16 bits is usually known after a few slices, unless the
  // caller allows an error.
  const bool reads_range = voxel_bytes(header_.type) > 2 || options_.max_error > 0;
  range_work_ = reads_range ? volume : 0;
  work_total_ = range_work_;
  for (uint32_t l = 0; l < levels; ++l) {
    const Index3 cells = level_grid(n, l).cells;
    work_total_ += static_cast<uint64_t>(cells.x) * static_cast<uint64_t>(cells.y) *
                   static_cast<uint64_t>(cells.z);
  }

  const auto scan = scan_volume(source_, threads_, reads_range, [&](uint64_t voxels) {
    report("reading the value range", reads_range ? voxels : 0);
  });
  if (!scan) return tl::unexpected(scan.error());
  auto quantization = choose_quantization(header_, *scan, options_.max_error);
  if (!quantization) return tl::unexpected(quantization.error());
  quantization_ = std::move(*quantization);
  mapping_ = quantization_.mapping();
  reader_.emplace(source_, quantization_, threads_);
  if (auto created = create_budget(writer->bytes_written()); !created) {
    return tl::unexpected(created.error());
  }
  encoding_start_ = Clock::now();
  for (uint32_t l = 0; l < levels; ++l) {
    if (auto built = build_level(l, *writer); !built) return tl::unexpected(built.error());
  }

  for (size_t t = 1; t < workers_.size(); ++t) workers_[0].statistics.add(workers_[t].statistics);
  const VolumeStatistics& statistics = workers_[0].statistics;
  StoreInfo info;
  info.grid = header_.grid;
  info.mapping = mapping_;
  info.range = statistics.range();
  info.missing_voxels = statistics.missing();
  info.metadata = metadata_json(header_, options_, info, statistics);
  auto finished = writer->finish(info);
  if (!finished) return tl::unexpected(finished.error());
  BuildReport report;
  report.info = std::move(*finished);
  report.raw_bytes = volume * voxel_bytes(header_.type);
  report.max_bytes = max_bytes_;
  report.needed_bytes = plan_.bytes;
  for (uint32_t l = 1; l < levels; ++l) report.uses_temporary_files |= !plan_.in_memory[l];
  report.seconds = seconds_since(start_);
  return report;
}

}  // namespace

uint64_t min_memory(const VolumeSource& source, const BuildOptions& options) {
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  return plan_memory(source.header(), source.resident_bytes(), threads, UINT64_MAX)->min_bytes;
}

Result<BuildReport> build_store(VolumeSource& source, ByteSink& sink, const BuildOptions& options) {
  try {
    return Builder(source, options).build(sink);
  } catch (const std::bad_alloc&) {
    return fail(Status::out_of_memory,
                "the system refused memory while the store was built: close other programs, or "
                "reduce --memory or --threads");
  } catch (const std::system_error& error) {
    return fail(
        Status::out_of_memory,
        fmt::format("cannot start the build's threads ({}): reduce --threads", error.what()));
  }
}

Result<BuildReport> build_store_file(VolumeSource& source, const std::filesystem::path& target,
                                     const BuildOptions& options) {
  auto file = OutputFile::create(target);
  if (!file) return tl::unexpected(file.error());
  BuildOptions with_folder = options;
  if (with_folder.temporary_folder.empty()) {
    with_folder.temporary_folder = target.has_parent_path() ? target.parent_path() : ".";
  }
  auto report = build_store(source, *file, with_folder);
  if (!report) return report;
  if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  return report;
}

}  // namespace isosplat
