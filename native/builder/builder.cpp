#include "native/builder/builder.h"

#include <algorithm>
#include <optional>
#include <thread>

#include "native/builder/file_slices.h"
#include "native/builder/kept_blocks.h"
#include "native/builder/layer_blocks.h"
#include "native/builder/output_build.h"
#include "native/builder/ranged_build.h"
#include "native/builder/shared_bands.h"
#include "native/builder/thread_executor.h"
#include "shared/core/builder/scan_volume.h"

namespace isosplat {
namespace {

/// One thread's part of a layer.
void build_blocks(StoreBuild& build, LayerBlocks& blocks, BandsEncoder& bands,
                  BlockEncoder& encoder, KeptBlocks* kept, bool is_counted) {
  std::vector<std::byte> buffer;
  while (auto task = blocks.begin()) {
    task->is_counted = is_counted;
    EncodedBlock encoded;
    bool is_taken = false;
    if (kept) {
      const auto taken = kept->take(build.layer(), build.coarser(), *task, buffer, encoded);
      if (!taken) return blocks.fail(taken.error());
      is_taken = *taken;
      if (!is_taken && !blocks.load()) return;
    }
    if (!is_taken) {
      encoder.encode(build.layer(), build.coarser(), *task, bands, encoded);
      if (kept) {
        const auto stored = kept->keep(build.layer(), build.coarser(), *task, encoded, buffer);
        if (!stored) return blocks.fail(stored.error());
      }
    }
    blocks.add(task->number, std::move(encoded));
  }
}

/// is_counted: whether the statistics of the layer are known.
Result<void> build_layer(StoreBuild& build, std::vector<BlockEncoder>& encoders, KeptBlocks* kept,
                         bool is_counted) {
  const auto threads = static_cast<unsigned>(encoders.size());
  LayerBlocks blocks(build);
  SharedBands bands(threads);
  on_threads(threads, [&](unsigned thread) {
    BlockEncoder& encoder = encoders[thread];
    try {
      build_blocks(build, blocks, bands, encoder, kept, is_counted);
    } catch (...) {
      blocks.stop();  // other threads may wait there for this thread's block
      bands.help(encoder.chunk_encoder());
      throw;
    }
    bands.help(encoder.chunk_encoder());
  });
  return blocks.result();
}

Result<BuildReport> build_on_threads(VolumeSource& source, ByteSink& sink,
                                     const BuildOptions& options) {
  ThreadExecutor executor(thread_count(options));
  FileSliceStorage storage(options.temporary_folder.empty() ? std::filesystem::temp_directory_path()
                                                            : options.temporary_folder);
  StoreBuild build(source, sink, options, executor, executor.threads(), &storage);
  if (auto begun = build.begin(); !begun) return tl::unexpected(begun.error());
  std::vector<BlockEncoder> encoders(executor.threads());
  KeptBlocks* const kept = options.kept;
  std::optional<VolumeStatistics> known;  // of the layers that are kept
  if (kept) {
    known.emplace();
    const uint64_t blocks = level_grid(source.header().grid.voxels, 0).block_count();
    if (auto begun = kept->begin(block_file_key(build, options), blocks, *known); !begun) {
      return tl::unexpected(begun.error());
    }
  }
  for (;;) {
    const auto has_layer = build.advance_layer();
    if (!has_layer) return tl::unexpected(has_layer.error());
    if (!*has_layer) break;
    const bool is_finest = build.layer().grid.level == 0;
    const bool is_known = kept && (!is_finest || kept->knows_layer(build.layer_z()));
    if (!is_known) {
      if (auto loaded = build.load_layer(true); !loaded) return tl::unexpected(loaded.error());
    }
    auto built = build_layer(build, encoders, kept, is_known);
    if (!built) return tl::unexpected(built.error());
    if (kept && is_finest && !is_known && build.is_last_band()) {
      VolumeStatistics of_layer;
      build.take_values(of_layer);
      for (BlockEncoder& encoder : encoders) {
        of_layer.add(encoder.statistics);
        encoder.statistics = VolumeStatistics();
      }
      known->add(of_layer);
      auto stored = kept->keep_statistics(build.layer_z(), of_layer);
      if (!stored) return tl::unexpected(stored.error());
    }
  }
  for (size_t t = 1; t < encoders.size(); ++t) encoders[0].statistics.add(encoders[t].statistics);
  if (known) encoders[0].statistics.add(*known);
  return build.finish(encoders[0].statistics);
}

}  // namespace

unsigned thread_count(const BuildOptions& options) {
  return options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
}

uint64_t min_memory(const VolumeSource& source, const BuildOptions& options) {
  return plan_memory(source.header(), source.resident_bytes(), source.reads_rows(),
                     thread_count(options), true, UINT64_MAX)
      ->min_bytes;
}

Result<VoxelScan> scan_for_build(VolumeSource& source, const BuildOptions& options) {
  return with_refusals([&] {
    ThreadExecutor executor(thread_count(options));
    return scan_volume(source, executor, scans_all(source.header(), options.max_error),
                       [](uint64_t) {});
  });
}

Result<BuildReport> build_store(VolumeSource& source, ByteSink& sink, const BuildOptions& options) {
  return with_range(source, options, [&sink](VolumeSource& volume, const BuildOptions& ranged) {
    return build_on_threads(volume, sink, ranged);
  });
}

Result<BuildReport> build_store_file(VolumeSource& source, const std::filesystem::path& target,
                                     const BuildOptions& options) {
  return build_output_file(target, options, [&](ByteSink& sink, const BuildOptions& with_folder) {
    return build_store(source, sink, with_folder);
  });
}

}  // namespace isosplat
