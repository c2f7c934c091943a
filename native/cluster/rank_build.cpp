#include "native/cluster/rank_build.h"

#include <thread>

#include "native/builder/file_slices.h"
#include "native/builder/output_build.h"
#include "native/builder/refusals.h"
#include "native/cluster/messages.h"
#include "native/cluster/ranged_volume.h"
#include "native/cluster/rank_coordinator.h"
#include "native/cluster/rank_pause.h"

namespace isosplat {
namespace {

Result<BuildReport> build_on_ranks(VolumeSource& source, ByteSink& sink, BuildOptions options,
                                   ClampedSource* clamped, Transport& transport) {
  RankCoordinator coordinator(source, options, transport);
  if (auto ready = coordinator.wait_for_ranks(); !ready) return tl::unexpected(ready.error());
  const auto start = std::chrono::steady_clock::now();
  if (!options.scan) {
    auto scan = coordinator.scan();
    if (!scan) return tl::unexpected(scan.error());
    options.scan = std::move(*scan);
  }
  coordinator.quantize(*options.scan);
  ThreadExecutor executor(thread_count(options));
  FileSliceStorage storage(options.temporary_folder.empty() ? std::filesystem::temp_directory_path()
                                                            : options.temporary_folder);
  StoreBuild build(source, sink, options, executor, executor.threads() + kMessageEncoders,
                   &storage);
  if (auto begun = build.begin(); !begun) return tl::unexpected(begun.error());
  coordinator.begin(build, *options.scan);
  for (;;) {
    const auto has_layer = build.advance_layer();
    if (!has_layer) return tl::unexpected(has_layer.error());
    if (!*has_layer) break;
    if (auto built = coordinator.build_layer(build); !built) return tl::unexpected(built.error());
  }
  VolumeStatistics statistics;
  if (auto finished = coordinator.finish(statistics, clamped); !finished) {
    return tl::unexpected(finished.error());
  }
  auto report = build.finish(statistics);
  if (!report) return report;
  report->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace

Result<BuildReport> build_store_on_ranks(VolumeSource& source, ByteSink& sink,
                                         const BuildOptions& options, Transport& transport) {
  if (options.kept || options.only_isovalue || options.coarse_levels) {
    return fail(Status::invalid_argument,
                "expected a build of a volume by several ranks, found options of parts or labels");
  }
  return with_refusals([&]() -> Result<BuildReport> {
    auto volume = RangedVolume::create(source, options);
    if (!volume) return tl::unexpected(volume.error());
    BuildOptions with_scan = options;
    if (volume->clamped()) with_scan.scan = volume->clamped()->all_values();
    auto report = build_on_ranks(volume->source(), sink, with_scan, volume->clamped(), transport);
    if (options.clamped && volume->clamped()) *options.clamped = volume->clamped()->clamped();
    return report;
  });
}

Result<BuildReport> build_store_file_on_ranks(VolumeSource& source,
                                              const std::filesystem::path& target,
                                              const BuildOptions& options, Transport& transport) {
  return build_output_file(target, options, [&](ByteSink& sink, const BuildOptions& with_folder) {
    return build_store_on_ranks(source, sink, with_folder, transport);
  });
}

void stop_ranks(Transport& transport, int exit_code) {
  for (int rank = 1; rank < transport.ranks(); ++rank) {
    transport.send(rank, MessageKind::stop, packed(exit_code));
  }
  while (transport.is_busy()) {
    transport.receive();
    std::this_thread::sleep_for(pause_of(transport));
  }
}

}  // namespace isosplat
