#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "shared/core/builder/executor.h"
#include "shared/core/builder/layer_output.h"
#include "shared/core/builder/layer_reader.h"
#include "shared/core/builder/memory_plan.h"
#include "shared/core/builder/slice_store.h"
#include "shared/core/builder/store_options.h"
#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// The build of a store, without threads and files. It reads the source and writes the store;
/// encoding the blocks, which is nearly all of the work, is left to the caller's BlockEncoders: on
/// the caller's threads, or in workers that have their own memory (block_transfer.h). The bytes of
/// the store do not depend on who encodes which block, or when.
///
///     StoreBuild build(…);
///     build.begin();
///     while (build.next_layer()) {          // reads a layer of blocks, or a band of it
///       while (!build.layer_is_complete()) {
///         // as long as there are tasks and free encoders: task = build.begin_block()
///         // encoder.encode(build.layer(), build.coarser(), task, …, encoded)
///         build.add_block(task.number, encoded);
///       }
///     }
///     build.finish(statistics of all encoders);
///
/// If the memory limit does not allow whole layers, "the layer" is a band of rows of blocks
/// (MemoryPlan::band_rows). The bytes of the store do not depend on this either.
///
/// One thread calls it at a time; encoders use layer() and coarser() meanwhile. A build can be
/// abandoned between any two calls. After an error, no function may be called.
///
/// Memory: MemoryPlan, of which the encoders take kThreadBytes each.
class StoreBuild {
 public:
  /// All arguments must outlive the build. encoders: how many, for the memory plan. storage: for
  /// coarse levels that do not fit in memory; null if there is none.
  StoreBuild(VolumeSource& source, ByteSink& sink, const StoreOptions& options, Executor& executor,
             unsigned encoders, SliceStorage* storage);

  /// Plans the memory; reads the source for the range of values (integers of up to 16 bits: usually
  /// only the first slices), and some slices as a sample for the size forecast. Errors: those of
  /// choose_quantization, no_cells, volume_too_large, out_of_memory (before the source is read,
  /// with the memory needed), and those of the source.
  Result<void> begin();

  /// Begins the next layer of blocks: reads its slices from the source, or a coarse level. False if
  /// there are no more. Requires layer_is_complete(). Errors: those of the source; io_error.
  Result<bool> next_layer();

  /// next_layer() in two steps, for layers whose encoded blocks are known: load_layer() is needed
  /// only before a block is encoded. Reads nothing if the layer is loaded. counts_values: whether
  /// finish() shall count the voxels of the layer; else its caller knows them.
  Result<bool> advance_layer();
  Result<void> load_layer(bool counts_values);

  /// Begins a band of the layer z of level 0 for a part of a build, which encodes some of its
  /// blocks and writes no store: others may be left out, and neither begin_block() nor add_block()
  /// may be called. As next_layer() otherwise. counted: the rows of blocks whose voxels finish()
  /// shall count.
  Result<void> begin_part_band(int32_t z, BlockRows band, BlockRows counted);
  /// Rows of blocks of the bands of level 0.
  int32_t band_rows() const { return plan_.band_rows[0]; }
  /// The task of a block of that layer. Its λ is that of a store whose size limit changes nothing.
  BlockTask part_task(size_t number) const;
  /// Reports the progress of a part with `blocks` blocks, of which `done` were encoded.
  void report_part(size_t done, size_t blocks);

  const Layer& layer() const { return layer_; }
  const CoarserLayer& coarser() const { return coarser_; }

  /// The next block of the layer to encode. None if there is none now: after the next add_block()
  /// there may be one, unless layer_is_begun().
  std::optional<BlockTask> begin_block() { return output_->begin_block(); }
  bool layer_is_begun() const { return output_->is_begun(); }
  /// Of the layer: its index along z, in blocks.
  int32_t layer_z() const { return z_; }
  /// Whether the next layer has another z or level.
  bool is_last_band() const { return band_.end == layer_.grid.blocks.y; }
  bool layer_is_complete() const { return !output_ || output_->is_complete(); }

  /// Adds an encoded block of the layer. Its part of coarser() must have been written. Errors:
  /// io_error, and those of StoreWriter::add_block.
  Result<void> add_block(size_t number, EncodedBlock&& encoded);

  /// Writes the directory and the header. statistics: of the cells of level 0, as the encoders have
  /// counted them. Errors: io_error.
  Result<BuildReport> finish(const VolumeStatistics& statistics);

  /// Adds the counts of the voxels read so far to `statistics`, and begins to count anew.
  void take_values(VolumeStatistics& statistics) { reader_->take_values(statistics); }

  /// Identifies volume and options by the header, the metadata, the mapping and the sample, but not
  /// by all voxels. Builds of a volume with equal keys give the same store. Call after begin().
  uint64_t key() const;

  /// The distribution of isovalues that the tasks' options refer to. Set by begin().
  const std::vector<double>& isovalue_distribution() const { return isovalue_distribution_; }

 private:
  using Clock = std::chrono::steady_clock;
  /// Voxels and intervals of a coarse level, from their computation until the level is encoded.
  struct PendingLevel {
    std::unique_ptr<SliceStore> voxels, intervals;
  };

  /// A layer of a level, without its voxels.
  Layer layer_of(uint32_t level) const;
  Result<void> begin_level();
  Result<void> end_band();
  /// Sets band_ to the band that begins with a row of blocks.
  void begin_band(int32_t first);
  /// Sets the boxes of the band, and of its part of the coarser level.
  void set_boxes();
  /// Reads the voxels of the band, of level 0, from the source.
  Result<void> read_band(BlockRows counted);
  /// The same for a coarse level, from where it is pending.
  Result<void> load_coarse_band();
  Result<std::unique_ptr<SliceStore>> create_slices(uint32_t level, size_t item_bytes,
                                                    const LevelBox& all);
  Result<void> create_budget();
  void report(const char* phase, uint64_t voxels_done);

  VolumeSource& source_;
  ByteSink& sink_;
  const VolumeHeader& header_;
  const StoreOptions& options_;
  Executor& executor_;
  const unsigned encoders_;
  SliceStorage* const storage_;
  const uint32_t levels_;

  MemoryPlan plan_;
  std::optional<StoreWriter> writer_;
  Quantization quantization_;
  ValueMapping mapping_;
  BandOptions band_options_;
  std::vector<double> isovalue_distribution_;
  std::optional<QuantizedValue> only_isovalue_;
  uint64_t max_bytes_ = 0;  // of the store
  std::optional<SizeForecast> forecast_;
  std::optional<SizeBudget> budget_;
  std::optional<LayerReader> reader_;
  std::vector<PendingLevel> pending_;  // per level

  int32_t z_ = 0;        // of the current layer, in blocks
  BlockRows band_ = {};  // of the current layer
  Layer layer_;
  CoarserLayer coarser_;
  std::vector<std::byte> part_voxels_, part_intervals_;  // of a part: its part of level 1
  std::optional<LayerOutput> output_;

  Clock::time_point start_ = Clock::now(), encoding_start_ = start_, last_report_ = start_;
  uint64_t work_total_ = 0;  // voxels of all levels, and of reading the range
  uint64_t work_done_ = 0, range_work_ = 0;
};

}  // namespace isosplat
