#pragma once

#include <span>
#include <string>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// "chunk 2/1.0.3/5": level, block, band.
std::string name_of(const ChunkRef& chunk);

/// The unions of the intervals of each 2×2×2 cells of a block. The coarser block must contain them.
struct HalvedBlock {
  Index3 cells;
  std::vector<CellInterval> intervals;  ///< {65535, 0} if none of the cells is in a chunk
};

/// Checks the chunks of a block against the directory and against each other. Can be used for one
/// block after the other.
class BlockVerifier {
 public:
  /// Starts a block.
  void begin(const BlockRef& block, Index3 cells);

  /// Checks the next band's chunk, which has these bytes. Errors: checksum_mismatch,
  /// malformed_chunk, truncated.
  Result<void> add(const ChunkRef& chunk, std::span<const std::byte> bytes);

  /// Checks the block after its last chunk. Errors: malformed_page.
  Result<void> end();

  /// Sets `halved` from the cells of this block.
  void halve(HalvedBlock& halved) const;

  /// Checks that the intervals of this block's cells contain those of the child at an octant.
  /// Errors: malformed_chunk.
  Result<void> contains(Index3 octant, const HalvedBlock& child) const;

 private:
  // `decoded`: index of a cell in decoded_; `at`: its index in the block.
  Result<void> decode(const ChunkRef& chunk, std::span<const std::byte> bytes);
  Result<void> check_interval(const ChunkRef& chunk, size_t decoded, size_t at);
  Result<void> check_corners(const ChunkRef& chunk, size_t decoded, Index3 cell);
  size_t cell_at(Index3 cell) const {
    return static_cast<size_t>((cell.z * cells_.y + cell.y) * cells_.x + cell.x);
  }

  BlockRef block_;
  Index3 cells_;
  ChunkDecoder decoder_;
  DecodedCells decoded_;
  std::vector<CellInterval> intervals_;  // {65535, 0}: not seen
  std::vector<uint16_t> last_band_;      // 1 + the last band that contained the cell; 0: none
  std::vector<int32_t> voxels_;          // −1: not seen
  CellInterval united_;
  uint32_t reaching_ = 0;  // cells of the last band that must be in the next, too
};

}  // namespace isosplat
