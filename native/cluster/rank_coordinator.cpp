#include "native/cluster/rank_coordinator.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/scan_volume.h"

namespace isosplat {
namespace {

/// Encoded blocks wait for those before them. This bounds their number.
constexpr size_t kMinAhead = 64;

}  // namespace

RankCoordinator::RankCoordinator(VolumeSource& source, const BuildOptions& options,
                                 Transport& transport)
    : source_(source),
      options_(options),
      transport_(transport),
      worker_(source, options, transport),
      threads_(static_cast<size_t>(transport.ranks())),
      outstanding_(threads_.size()) {
  threads_[0] = thread_count(options);
}

Result<void> RankCoordinator::receive(const std::function<Result<void>(const Message&)>& handle) {
  auto message = transport_.receive();
  if (message) {
    switch (message->kind) {
      case MessageKind::failed: {
        Error error = failure_of(message->content);
        error.message = fmt::format("rank {}: {}", message->from, error.message);
        return tl::unexpected(std::move(error));
      }
      case MessageKind::scan:
      case MessageKind::quantize:
      case MessageKind::begin:
      case MessageKind::order:
      case MessageKind::task:
        if (auto handled = worker_.handle(std::move(*message)); !handled) return handled;
        break;
      default:
        if (auto handled = handle(*message); !handled) return handled;
    }
  }
  const auto sent = worker_.send_finished();
  if (!sent) return tl::unexpected(sent.error());
  if (!message && !*sent) worker_.wait();
  return {};
}

Result<void> RankCoordinator::wait_for_ranks() {
  const uint64_t digest = volume_digest(source_.header());
  while (std::count(threads_.begin(), threads_.end(), 0u) > 0) {
    auto received = receive([&](const Message& message) -> Result<void> {
      RankReady ready;
      if (message.kind != MessageKind::ready || !unpack(message.content, ready) ||
          ready.threads == 0) {
        return malformed_message();
      }
      if (ready.volume != digest) {
        return fail(Status::invalid_argument,
                    fmt::format("rank {}: expected the volume that rank 0 has opened, found one of "
                                "another size or type: give the path of one volume on all machines",
                                message.from));
      }
      threads_[static_cast<size_t>(message.from)] = ready.threads;
      return {};
    });
    if (!received) return received;
  }
  const size_t all = std::accumulate(threads_.begin(), threads_.end(), size_t{0});
  max_ahead_ = std::max(kMinAhead, 2 * all);
  return {};
}

Result<std::shared_ptr<const VoxelScan>> RankCoordinator::scan() {
  auto scan = std::make_shared<VoxelScan>(source_.header().type);
  if (!scans_all(source_.header(), options_.max_error)) {
    // Usually, the first slices suffice.
    ThreadExecutor executor(thread_count(options_));
    const auto scanned = scan_volume(source_, executor, false, [](uint64_t) {});
    if (!scanned) return tl::unexpected(scanned.error());
    scan->add(*scanned);
    return scan;
  }
  if (options_.progress) options_.progress({"reading the value range", 0, 0, 0});
  const int ranks = transport_.ranks();
  const auto share = [&](int rank) {
    return static_cast<int32_t>(int64_t{source_.header().grid.voxels.z} * rank / ranks);
  };
  // Rank 0 scans when it handles its own message, after all others were sent.
  for (int rank = ranks - 1; rank >= 0; --rank) {
    transport_.send(rank, MessageKind::scan, packed(ScanOrder{share(rank), share(rank + 1)}));
  }
  for (int left = ranks; left > 0;) {
    auto received = receive([&](const Message& message) -> Result<void> {
      if (message.kind != MessageKind::scanned) return malformed_message();
      --left;
      return scan->add_message(message.content);
    });
    if (!received) return tl::unexpected(received.error());
  }
  return scan;
}

void RankCoordinator::quantize(const VoxelScan& scan) {
  const auto message = scan.bytes();
  for (int rank = 1; rank < transport_.ranks(); ++rank) {
    transport_.send(rank, MessageKind::quantize, message);
  }
}

void RankCoordinator::begin(const StoreBuild& build, const VoxelScan& scan) {
  transport_.send(0, MessageKind::quantize, scan.bytes());
  const auto distribution = std::as_bytes(std::span(build.isovalue_distribution()));
  for (int rank = 0; rank < transport_.ranks(); ++rank) {
    transport_.send(rank, MessageKind::begin, {distribution.begin(), distribution.end()});
  }
}

int RankCoordinator::free_rank(int owner) const {
  const auto load = [&](size_t rank) {
    return static_cast<double>(outstanding_[rank]) / threads_[rank];
  };
  size_t best = static_cast<size_t>(owner);
  for (size_t rank = 0; rank < threads_.size(); ++rank) {
    if (load(rank) < load(best)) best = rank;
  }
  return outstanding_[best] < capacity(best) ? static_cast<int>(best) : -1;
}

bool RankCoordinator::give_out(StoreBuild& build, int owner) {
  const int rank = free_rank(owner);
  if (rank < 0 || build.layer_is_begun()) return false;
  if (missing_.size() > 0 && *missing_.rbegin() + 1 >= *missing_.begin() + max_ahead_) return false;
  const auto task = build.begin_block();
  if (!task) return false;
  missing_.insert(task->number);
  ++outstanding_[static_cast<size_t>(rank)];
  if (build.layer().grid.level == 0) {
    transport_.send(owner, MessageKind::order, packed(order_of(*task, rank)));
  } else {
    std::vector<std::byte> message;
    write_task(build.layer(), build.coarser(), *task, source_.header().grid.voxels, message);
    transport_.send(rank, MessageKind::task, std::move(message));
  }
  return true;
}

Result<void> RankCoordinator::build_layer(StoreBuild& build) {
  const bool is_finest = build.layer().grid.level == 0;
  const int owner = is_finest ? layer_reader_of(build.layer_z(), transport_.ranks()) : 0;
  if (!is_finest) {
    if (auto loaded = build.load_layer(false); !loaded) return loaded;
  }
  while (!build.layer_is_complete()) {
    while (give_out(build, owner)) {
    }
    auto received = receive([&](const Message& message) -> Result<void> {
      if (message.kind != MessageKind::encoded) return malformed_message();
      EncodedBlock block;
      const auto number = read_encoded(message.content, build.layer(), build.coarser(), block);
      if (!number) return tl::unexpected(number.error());
      if (missing_.erase(*number) == 0) return malformed_message();
      --outstanding_[static_cast<size_t>(message.from)];
      return build.add_block(*number, std::move(block));
    });
    if (!received) return received;
  }
  return {};
}

Result<void> RankCoordinator::finish(VolumeStatistics& statistics, ClampedSource* clamped) {
  statistics.add(worker_.statistics());
  for (int rank = 1; rank < transport_.ranks(); ++rank) {
    transport_.send(rank, MessageKind::finish, {});
  }
  for (int left = transport_.ranks() - 1; left > 0;) {
    auto received = receive([&](const Message& message) -> Result<void> {
      std::span<const std::byte> counts, slices;
      if (message.kind != MessageKind::statistics ||
          !unpack_parts(message.content, counts, slices)) {
        return malformed_message();
      }
      --left;
      if (clamped) clamped->add_slices(numbers_of<ClampedVoxels>(slices));
      return statistics.add(counts);
    });
    if (!received) return received;
  }
  return {};
}

}  // namespace isosplat
