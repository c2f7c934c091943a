#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "shared/codec/band_masks.h"
#include "shared/codec/chunk_codec.h"
#include "shared/store/store_writer.h"

namespace isosplat {

/// Lets threads that have no block left encode bands of the blocks that others are at, so that none
/// is idle while the last blocks of a layer, or the few of a coarse level, are encoded. Chunks do
/// not depend on who encodes them.
class SharedBands {
 public:
  /// For so many threads, each of which encodes blocks, then calls help().
  explicit SharedBands(unsigned threads) : busy_(threads) {}

  /// Encodes the bands of a block that end at `ends` and begin with `begin`, and appends them to
  /// `bands` and `bytes` in their order. Others may help. masks: which cells each of them holds.
  /// Throws std::bad_alloc, also where it was another thread that had no memory left.
  void encode(ChunkEncoder& encoder, const BlockVoxels& view, const BandMasks& masks,
              uint32_t begin, std::span<const uint32_t> ends, std::vector<BandChunk>& bands,
              std::vector<std::byte>& bytes);

  /// Encodes bands of other threads' blocks until no thread has a block. Each thread has to call
  /// it, also where encoding a block has failed: the others wait for it.
  void help(ChunkEncoder& encoder) noexcept;

 private:
  /// A block whose bands are encoded: by its own thread from the first on, by others from the last.
  struct OpenBlock {
    const BlockVoxels& view;
    const BandMasks& masks;
    uint32_t begin;
    std::span<const uint32_t> ends;
    size_t next = 0;                             ///< bands below are taken by its own thread
    size_t helped;                               ///< bands from here on are taken by others
    size_t helpers = 0;                          ///< bands that others are encoding
    std::vector<BandChunk> bands;                ///< of others, the last one first
    std::vector<std::vector<std::byte>> chunks;  ///< likewise
    bool out_of_memory = false;                  ///< a helper had no memory for its band
  };
  static BandChunk encode_band(ChunkEncoder& encoder, const OpenBlock& block, size_t band,
                               std::vector<std::byte>& bytes);

  /// Offers no more bands of a block, and waits for those that others are at. `lock`: of mutex_.
  void close(OpenBlock& block, std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<OpenBlock*> open_;  ///< with bands that nobody has taken
  unsigned busy_;                 ///< threads that may still open blocks
};

}  // namespace isosplat
