#include "native/builder/builder.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "native/builder/file_slices.h"
#include "native/builder/refusals.h"
#include "native/builder/shared_bands.h"
#include "native/builder/thread_executor.h"
#include "native/files/output_file.h"
#include "shared/core/builder/scan_volume.h"
#include "shared/core/builder/store_build.h"

namespace isosplat {
namespace {

unsigned thread_count(const BuildOptions& options) {
  return options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
}

/// Distributes the blocks of a layer to several threads: begins and adds blocks of the build, and
/// waits.
class LayerBlocks {
 public:
  explicit LayerBlocks(StoreBuild& build) : build_(build) {}

  /// The next block. Waits for earlier ones. No value if all were begun, if adding one has failed,
  /// or after stop().
  std::optional<BlockTask> begin() {
    std::unique_lock lock(mutex_);
    std::optional<BlockTask> task;
    changed_.wait(lock, [&] {
      if (!result_ || is_stopped_ || build_.layer_is_begun()) return true;
      task = build_.begin_block();
      return task.has_value();
    });
    return task;
  }

  /// Adds an encoded block. After the first error, nothing more is added.
  void add(size_t number, EncodedBlock&& encoded) {
    const std::lock_guard lock(mutex_);
    if (result_) result_ = build_.add_block(number, std::move(encoded));
    changed_.notify_all();
  }

  /// Ends all waits, since no more blocks will be added.
  void stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    changed_.notify_all();
  }

  /// The first error. Call after all threads have ended.
  const Result<void>& result() const { return result_; }

 private:
  StoreBuild& build_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_stopped_ = false;
  Result<void> result_;
};

Result<void> build_layer(StoreBuild& build, std::vector<BlockEncoder>& encoders) {
  const auto threads = static_cast<unsigned>(encoders.size());
  LayerBlocks blocks(build);
  SharedBands bands(threads);
  on_threads(threads, [&](unsigned thread) {
    BlockEncoder& encoder = encoders[thread];
    try {
      while (const auto task = blocks.begin()) {
        EncodedBlock encoded;
        encoder.encode(build.layer(), build.coarser(), *task, bands, encoded);
        blocks.add(task->number, std::move(encoded));
      }
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
  for (;;) {
    const auto has_layer = build.next_layer();
    if (!has_layer) return tl::unexpected(has_layer.error());
    if (!*has_layer) break;
    if (auto built = build_layer(build, encoders); !built) return tl::unexpected(built.error());
  }
  for (size_t t = 1; t < encoders.size(); ++t) encoders[0].statistics.add(encoders[t].statistics);
  return build.finish(encoders[0].statistics);
}

}  // namespace

uint64_t min_memory(const VolumeSource& source, const BuildOptions& options) {
  return plan_memory(source.header(), source.resident_bytes(), thread_count(options), true,
                     UINT64_MAX)
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
  if (!options.range) {
    return with_refusals([&] { return build_on_threads(source, sink, options); });
  }
  auto clamped = ClampedSource::create(source, *options.range);
  if (!clamped) return tl::unexpected(clamped.error());
  BuildOptions with_scan = options;
  with_scan.scan = clamped->all_values();
  auto report = with_refusals([&] { return build_on_threads(*clamped, sink, with_scan); });
  if (options.clamped) *options.clamped = clamped->clamped();
  return report;
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
