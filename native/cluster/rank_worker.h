#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "native/builder/builder.h"
#include "native/builder/clamped_source.h"
#include "native/builder/thread_executor.h"
#include "native/cluster/messages.h"
#include "native/cluster/transport.h"
#include "shared/core/builder/layer_reader.h"

namespace isosplat {

/// What each rank of a build does, rank 0 too: it reads every n-th layer of blocks of level 0,
/// sends each block of them to the rank that encodes it, and encodes blocks of any layer.
///
/// One thread calls the functions, and sends and receives all messages. Another thread reads the
/// layers, one ahead of the build. `threads` more encode.
class RankWorker {
 public:
  /// All arguments must outlive the worker. The source is read only by one thread at a time: the
  /// caller's until `quantize` is handled, then the worker's.
  RankWorker(VolumeSource& source, const BuildOptions& options, Transport& transport);
  /// Ends the threads, after the block and the layer that they work on.
  ~RankWorker();
  RankWorker(const RankWorker&) = delete;

  /// Handles `scan`, `quantize`, `begin`, `order` or `task`. Errors: those of the source and of
  /// choose_quantization; out_of_memory; invalid_argument (a malformed message).
  Result<void> handle(Message&& message);

  /// Sends the tasks whose layer was read, and the blocks that were encoded. Returns whether there
  /// were any. Errors: those of the source; out_of_memory.
  Result<bool> send_finished();

  /// Waits until send_finished() has something to send, or until it is time to look for messages.
  void wait();

  /// Of the blocks that were encoded and the layers that were read. No other function may be called
  /// afterwards.
  VolumeStatistics statistics();

 private:
  Result<void> scan(const ScanOrder& order);
  Result<void> quantize(std::span<const std::byte> scan_message);
  void begin(std::span<const std::byte> distribution);
  void read_layers();
  /// Reads a band, and waits until its tasks were sent. False if the worker shall end.
  bool read_band(int32_t z, BlockRows band);
  /// Whether the voxels of the first order were read. Requires mutex_.
  bool has_voxels_of_next() const;
  void encode_tasks(BlockEncoder& encoder);
  void stop();
  void fail_with(const Error& error);

  VolumeSource& source_;
  const BuildOptions& options_;
  Transport& transport_;
  ThreadExecutor executor_;
  const LevelGrid grid_;  // of level 0

  Quantization quantization_;
  std::vector<double> isovalue_distribution_;
  std::optional<LayerReader> reader_;
  int32_t band_rows_ = 1;  // rows of blocks of a band
  std::vector<BlockEncoder> encoders_;
  std::vector<std::jthread> threads_;

  std::mutex mutex_;  // of all that follows
  std::condition_variable work_, news_;
  bool is_stopping_ = false;
  std::optional<Error> error_;
  std::deque<std::vector<std::byte>> tasks_, encoded_;
  std::deque<TaskOrder> orders_;
  Layer layer_;  // the band that was read; no voxels: none is now
  int32_t layer_z_ = -1;
  BlockRows band_;         // of the layer
  size_t open_tasks_ = 0;  // of the band: those not yet ordered
  size_t encoding_ = 0;    // threads that encode
};

}  // namespace isosplat
