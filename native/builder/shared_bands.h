#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "shared/core/builder/block_encoder.h"

namespace isosplat {

/// Work stealing between the threads that encode a layer: a thread that has no block left encodes
/// bands of other threads' blocks. So no thread is idle during the last blocks of a layer or the
/// few blocks of a coarse level. The chunks do not depend on the thread that encodes them.
class SharedBands : public BandsEncoder {
 public:
  /// threads: the number of threads that encode blocks. Each calls help() when no block is left.
  explicit SharedBands(unsigned threads) : busy_(threads) {}

  /// Encodes the bands of a block; other threads may help. Throws std::bad_alloc if this thread or
  /// a helping one could not allocate memory.
  void encode(ChunkEncoder& encoder, const BlockVoxels& voxels, const BandMasks& masks,
              uint32_t begin, std::span<const uint32_t> ends, std::vector<BandChunk>& bands,
              std::vector<std::byte>& bytes) override;

  /// Encodes bands of other threads' blocks until all threads have called help(). Each thread must
  /// call it, even if encoding a block has failed: the other threads wait for it.
  void help(ChunkEncoder& encoder) noexcept;

 private:
  /// A block whose bands are being encoded. Its own thread encodes the bands [0, next), ascending;
  /// other threads encode the bands from `end` on, descending.
  struct OpenBlock {
    const BlockVoxels& voxels;
    const BandMasks& masks;
    uint32_t begin;
    std::span<const uint32_t> ends;
    size_t next = 0;
    size_t end;
    size_t helpers = 0;                          ///< bands that other threads are encoding
    std::vector<BandChunk> bands;                ///< of other threads, in descending order
    std::vector<std::vector<std::byte>> chunks;  ///< their bytes
    bool out_of_memory = false;  ///< another thread could not allocate memory for its band
  };
  static BandChunk encode_one(ChunkEncoder& encoder, const OpenBlock& block, size_t band,
                              std::vector<std::byte>& bytes);

  /// Stops offering bands of a block, and waits until other threads have encoded theirs. `lock`: of
  /// mutex_.
  void close(OpenBlock& block, std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<OpenBlock*> open_;  ///< blocks with bands that no thread has started
  unsigned busy_;                 ///< threads that have not called help() yet
};

}  // namespace isosplat
