#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "native/cluster/rank_worker.h"
#include "shared/core/builder/store_build.h"

namespace isosplat {

/// Rank 0 of a build: gives out the blocks, and receives them.
class RankCoordinator {
 public:
  /// All arguments must outlive the coordinator.
  RankCoordinator(VolumeSource& source, const BuildOptions& options, Transport& transport);

  /// Waits until all ranks have opened the volume. Errors: theirs; invalid_argument (a rank has
  /// opened another volume).
  Result<void> wait_for_ranks();

  /// The scan of a volume for StoreOptions::scan. The ranks share its slices if all must be read.
  /// Errors: those of the source.
  Result<std::shared_ptr<const VoxelScan>> scan();

  /// Tells all other ranks how to quantize voxels, so that they begin to read their layers.
  void quantize(const VoxelScan& scan);

  /// Tells rank 0's worker the same, and all ranks the distribution of isovalues. Call it after
  /// StoreBuild::begin(), which reads the source.
  void begin(const StoreBuild& build, const VoxelScan& scan);

  /// Builds the layer of the build, which advance_layer() has begun.
  Result<void> build_layer(StoreBuild& build);

  /// Adds the statistics of all ranks, and to `clamped` what they have clamped, unless it is null.
  Result<void> finish(VolumeStatistics& statistics, ClampedSource* clamped);

 private:
  /// Receives the next message for rank 0 itself; passes those for its worker to it. `handle` is
  /// called with it. Pauses if there is nothing to do. Errors: those of any rank.
  Result<void> receive(const std::function<Result<void>(const Message&)>& handle);
  /// Gives out the next block of the layer. False if there is none now, or no rank is free.
  bool give_out(StoreBuild& build, int owner);
  /// The rank that gets the next block, `owner` if others have no fewer; −1 if none is free.
  int free_rank(int owner) const;
  /// A rank encodes one block per thread, and has one more to begin with at once.
  unsigned capacity(size_t rank) const { return threads_[rank] + 1; }

  VolumeSource& source_;
  const BuildOptions& options_;
  Transport& transport_;
  RankWorker worker_;
  std::vector<unsigned> threads_;      // per rank; 0: not ready
  std::vector<unsigned> outstanding_;  // per rank: blocks given out and not received
  std::set<size_t> missing_;           // of the layer: numbers of these blocks
  size_t max_ahead_ = 0;  // how far a block may be ahead of the first missing one of its layer
};

}  // namespace isosplat
