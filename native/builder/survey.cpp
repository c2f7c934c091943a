#include "native/builder/survey.h"

#include <algorithm>
#include <thread>
#include <tuple>

#include "native/builder/thread_executor.h"
#include "shared/core/builder/quantized_reader.h"
#include "shared/core/builder/scan_volume.h"
#include "shared/core/preprocess/block_gather.h"
#include "shared/core/preprocess/quantization.h"

namespace isosplat {
namespace {

/// Scratch memory and statistics of one thread.
struct Counter {
  GatheredBlock block;
  BandPlanner planner;
  VolumeStatistics statistics;
};

}  // namespace

Result<VolumeSurvey> survey_volume(VolumeSource& source, size_t layer_bytes) {
  const Index3 n = source.header().grid.voxels;
  const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  ThreadExecutor executor(threads);
  const auto scan = scan_volume(source, executor, true, [](uint64_t) {});
  if (!scan) return tl::unexpected(scan.error());
  const auto quantization = choose_quantization(source.header(), *scan);
  if (!quantization) return tl::unexpected(quantization.error());
  VolumeSurvey survey;
  survey.mapping = quantization->mapping();
  survey.missing = scan->missing();
  if (!scan->is_empty()) {
    std::tie(survey.min, survey.max) =
        std::minmax({source.header().value(scan->min()), source.header().value(scan->max())});
  }

  std::vector<Counter> counters(threads);
  QuantizedReader reader(source, *quantization, executor);
  const auto count_values = [&](unsigned thread, const SliceRows& part, const std::byte* values) {
    counters[thread].statistics.add_values(values, part.voxels(n.x), survey.mapping.bits,
                                           survey.mapping.has_missing);
  };
  const size_t slice = reader.row_bytes() * static_cast<size_t>(n.y);
  const auto max_layer_slices = std::clamp<size_t>(layer_bytes / slice, 2, kBlockCells + 1);
  const int32_t max_cells = std::min(static_cast<int32_t>(max_layer_slices), n.z) - 1;
  std::vector<std::byte> buffer(slice * static_cast<size_t>(max_cells + 1));
  for (int32_t z = 0; z < n.z - 1; z += max_cells) {
    // The last slice of the previous layer is the first slice of this one.
    const int32_t cells = std::min(max_cells, n.z - 1 - z), kept = z > 0 ? 1 : 0;
    if (kept) std::copy_n(buffer.end() - static_cast<ptrdiff_t>(slice), slice, buffer.begin());
    if (auto read = reader.read({z + kept, cells + 1 - kept, 0, n.y},
                                buffer.data() + slice * static_cast<size_t>(kept), count_values);
        !read) {
      return tl::unexpected(read.error());
    }
    Layer layer;
    layer.grid = level_grid({n.x, n.y, cells + 1}, 0);
    layer.bits = survey.mapping.bits;
    layer.has_missing = survey.mapping.has_missing;
    layer.voxels = buffer.data();
    layer.voxel_box = voxel_slices(layer.grid, 0, cells + 1);
    const Index3 blocks = layer.grid.blocks;
    parallel_for(threads, layer.grid.block_count(), [&](unsigned thread, size_t i) {
      Counter& counter = counters[thread];
      const auto block = static_cast<int32_t>(i);
      gather_block(layer, {block % blocks.x, block / blocks.x, 0}, counter.block);
      counter.planner.count(counter.block.intervals);
      counter.statistics.add_block(counter.planner, counter.block);
    });
  }
  for (const Counter& counter : counters) survey.statistics.add(counter.statistics);
  return survey;
}

}  // namespace isosplat
