#pragma once

#include <string>
#include <vector>

#include "shared/codec/chunk_codec.h"
#include "shared/store/store_reader.h"

namespace isosplat {

/// "chunk 2/1.0.3/5": level, block, band.
std::string name_of(const ChunkRef& chunk);

/// The intervals of a block's cells, united over 2×2×2 cells: what the block above must contain.
struct HalvedBlock {
  Index3 cells;
  std::vector<CellInterval> intervals;  ///< {65535, 0} where no cell is in any chunk
};

/// Checks the chunks of one block against the directory and each other. Reusable.
class BlockVerifier {
 public:
  /// Starts a block.
  void begin(const BlockRef& block, Index3 cells);

  /// Checks the next band's chunk, whose bytes are in `bytes`. Errors: checksum_mismatch,
  /// malformed_chunk, truncated.
  Result<void> add(const ChunkRef& chunk);
  std::vector<std::byte> bytes;

  /// Checks what only the whole block shows. Errors: malformed_page.
  Result<void> end();

  void halve(HalvedBlock& halved) const;

  /// Whether the cells of this block contain those of the child at this octant. Errors:
  /// malformed_chunk.
  Result<void> contains(Index3 octant, const HalvedBlock& child) const;

 private:
  size_t cell_at(Index3 cell) const {
    return static_cast<size_t>((cell.z * cells_.y + cell.y) * cells_.x + cell.x);
  }

  BlockRef block_;
  Index3 cells_;
  ChunkDecoder decoder_;
  DecodedCells decoded_;
  std::vector<CellInterval> intervals_;  // {65535, 0}: not seen
  std::vector<uint16_t> last_band_;      // that the cell was in, plus 1
  std::vector<int32_t> voxels_;          // −1: not seen
  CellInterval united_;
  uint32_t reaching_ = 0;  // cells of the last band that must be in the next, too
};

}  // namespace isosplat
