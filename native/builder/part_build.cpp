#include "native/builder/part_build.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <mutex>

#include "native/builder/file_slices.h"
#include "native/builder/kept_blocks.h"
#include "native/builder/no_sink.h"
#include "native/builder/ranged_build.h"
#include "native/builder/shared_bands.h"
#include "native/builder/thread_executor.h"
#include "native/files/output_file.h"
#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/store_build.h"

namespace isosplat {
namespace {

/// Writes the blocks of a part.
class PartBuild {
 public:
  PartBuild(StoreBuild& build, BlockFileWriter& writer, unsigned threads, uint64_t blocks)
      : build_(build), writer_(writer), encoders_(threads), blocks_(blocks) {}

  /// Encodes the blocks [first, end) of the layer z.
  Result<void> add_layer(const LevelGrid& grid, int32_t z, size_t first, size_t end) {
    const auto across = static_cast<size_t>(grid.blocks.x);
    for (int32_t y = 0; y < grid.blocks.y; y += build_.band_rows()) {
      const BlockRows band = band_at(grid, y, build_.band_rows());
      const size_t begin = std::max(first, across * static_cast<size_t>(band.first));
      const size_t last = std::min(end, across * static_cast<size_t>(band.end));
      if (begin >= last) continue;
      // The part with the first block of a row of blocks counts its voxels.
      const auto rows_before = [&](size_t block) {
        return std::min(static_cast<int32_t>((block + across - 1) / across), band.end);
      };
      auto begun = build_.begin_part_band(z, band, {rows_before(begin), rows_before(last)});
      if (!begun) return begun;
      if (auto added = add_blocks(begin, last); !added) return added;
    }
    return {};
  }

  Result<void> finish() {
    VolumeStatistics statistics;
    build_.take_values(statistics);
    for (const BlockEncoder& encoder : encoders_) statistics.add(encoder.statistics);
    auto written = writer_.write(FrameKind::statistics, 0, 0, 0, statistics.bytes());
    if (!written) return written;
    return writer_.write(FrameKind::end, 0, 0, 0, {});
  }

 private:
  /// Encodes the blocks [first, end) of the band.
  Result<void> add_blocks(size_t first, size_t end) {
    SharedBands bands(static_cast<unsigned>(encoders_.size()));
    std::atomic<size_t> next{first};
    on_threads(static_cast<unsigned>(encoders_.size()), [&](unsigned thread) {
      BlockEncoder& encoder = encoders_[thread];
      try {
        std::vector<std::byte> message;
        for (size_t i = next++; i < end; i = next++) {
          const BlockTask task = build_.part_task(i);
          EncodedBlock encoded;
          encoder.encode(build_.layer(), build_.coarser(), task, bands, encoded);
          write_encoded(build_.layer(), build_.coarser(), i, encoded, message);
          add(task, message);
        }
      } catch (...) {
        next = end;
        bands.help(encoder.chunk_encoder());
        throw;
      }
      bands.help(encoder.chunk_encoder());
    });
    return result_;
  }

  void add(const BlockTask& task, std::span<const std::byte> message) {
    const std::lock_guard lock(mutex_);
    if (!result_) return;
    result_ = writer_.write(FrameKind::block, 0, static_cast<uint32_t>(task.index.z),
                            static_cast<uint32_t>(task.number), message);
    build_.report_part(static_cast<size_t>(++done_), static_cast<size_t>(blocks_));
  }

  StoreBuild& build_;
  BlockFileWriter& writer_;
  std::vector<BlockEncoder> encoders_;
  const uint64_t blocks_;
  std::mutex mutex_;
  uint64_t done_ = 0;
  Result<void> result_;
};

Result<PartReport> build_part(VolumeSource& source, OutputFile& file, const BuildOptions& options,
                              Part part) {
  const auto start = std::chrono::steady_clock::now();
  ThreadExecutor executor(thread_count(options));
  FileSliceStorage storage(options.temporary_folder);  // for the memory plan; not used
  NoSink sink;
  StoreBuild build(source, sink, options, executor, executor.threads(), &storage);
  if (auto begun = build.begin(); !begun) return tl::unexpected(begun.error());
  BlockFileWriter writer(file);
  if (auto written = writer.write_header({block_file_key(build, options), part}); !written) {
    return tl::unexpected(written.error());
  }
  const LevelGrid grid = level_grid(source.header().grid.voxels, 0);
  const uint64_t in_layer =
      static_cast<uint64_t>(grid.blocks.x) * static_cast<uint64_t>(grid.blocks.y);
  PartReport report;
  report.all_blocks = grid.block_count();
  const uint64_t first = report.all_blocks * (part.number - 1) / part.count;
  const uint64_t end = report.all_blocks * part.number / part.count;
  report.blocks = end - first;
  PartBuild blocks(build, writer, executor.threads(), report.blocks);
  for (uint64_t block = first; block < end;) {
    const uint64_t z = block / in_layer, layer = z * in_layer;
    const uint64_t layer_end = std::min(end, layer + in_layer);
    auto added = blocks.add_layer(grid, static_cast<int32_t>(z), static_cast<size_t>(block - layer),
                                  static_cast<size_t>(layer_end - layer));
    if (!added) return tl::unexpected(added.error());
    block = layer_end;
  }
  if (auto finished = blocks.finish(); !finished) return tl::unexpected(finished.error());
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace

Result<PartReport> build_part_file(VolumeSource& source, const std::filesystem::path& target,
                                   const BuildOptions& options, Part part) {
  if (part.number < 1 || part.number > part.count) {
    return fail(Status::invalid_argument,
                fmt::format("expected a part from 1 to {}, found {}", part.count, part.number));
  }
  auto file = OutputFile::create(target);
  if (!file) return tl::unexpected(file.error());
  auto report = with_range(source, options, [&](VolumeSource& volume, const BuildOptions& ranged) {
    return build_part(volume, *file, ranged, part);
  });
  if (!report) return report;
  if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  return report;
}

}  // namespace isosplat
