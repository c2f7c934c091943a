#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/points/chunk_samples.h"
#include "shared/core/points/lattice_gradients.h"

namespace isosplat {

/// The sums of gradients at the borders of a level's blocks. The smooth normals of a block need
/// those of its neighbours. Several threads may set() the borders of different blocks.
class BlockBorders {
 public:
  /// `blocks`: those that have a chunk, in raster order (x fastest), each once.
  explicit BlockBorders(std::vector<Index3> blocks);

  /// Sets the border of blocks[i] (LatticeGradients::border_of), or frees its memory.
  void set(size_t i, BlockBorder border) { borders_[i] = std::move(border); }
  void clear(size_t i) { borders_[i] = {}; }

  /// The memory of the border of blocks[i], in bytes.
  uint64_t memory(size_t i) const;

  /// project_samples() with smooth normals. The neighbours of frame.block that are in `blocks` must
  /// be set. All sums of `gradients` must be zero before; they are zero afterwards. places: see
  /// project_samples.
  PointArrays project(const DecodedCells& cells, const ChunkFrame& frame, float quantized_isovalue,
                      const ProjectionOptions& options, LatticeGradients& gradients,
                      std::vector<PointPlace>* places = nullptr) const;

 private:
  const BlockBorder* find(Index3 block) const;

  /// Calls f(border, offset) for the up to 26 neighbours of a block.
  template <class F>
  void for_neighbours(Index3 block, const F& f) const;

  std::vector<Index3> blocks_;
  std::vector<BlockBorder> borders_;  ///< of each of the blocks
};

}  // namespace isosplat
