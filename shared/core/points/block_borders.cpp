#include "shared/core/points/block_borders.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace isosplat {

BlockBorders::BlockBorders(std::vector<Index3> blocks)
    : blocks_(std::move(blocks)), borders_(blocks_.size()) {}

uint64_t BlockBorders::memory(size_t i) const {
  uint64_t bytes = sizeof(BlockBorder);
  for (const auto& list : borders_[i]) bytes += list.capacity() * sizeof(LatticeGradient);
  return bytes;
}

const BlockBorder* BlockBorders::find(Index3 block) const {
  const auto is_before = [](Index3 a, Index3 b) {
    return std::tuple(a.z, a.y, a.x) < std::tuple(b.z, b.y, b.x);
  };
  const auto found = std::lower_bound(blocks_.begin(), blocks_.end(), block, is_before);
  if (found == blocks_.end() || *found != block) return nullptr;
  return &borders_[static_cast<size_t>(found - blocks_.begin())];
}

template <class F>
void BlockBorders::for_neighbours(Index3 block, const F& f) const {
  for (int32_t dz = -1; dz <= 1; ++dz) {
    for (int32_t dy = -1; dy <= 1; ++dy) {
      for (int32_t dx = -1; dx <= 1; ++dx) {
        const Index3 offset{dx, dy, dz};
        if (offset == Index3{}) continue;
        if (const BlockBorder* border = find(block + offset)) f(*border, offset);
      }
    }
  }
}

PointArrays BlockBorders::project(const DecodedCells& cells, const ChunkFrame& frame,
                                  float quantized_isovalue, const ProjectionOptions& options,
                                  LatticeGradients& gradients,
                                  std::vector<PointPlace>* places) const {
  gradients.add(cells);
  for_neighbours(frame.block.index,
                 [&](const BlockBorder& border, Index3 offset) { gradients.add(border, offset); });
  PointArrays points =
      project_samples(cells, frame, quantized_isovalue, options, &gradients, places);
  gradients.remove(cells);
  for_neighbours(frame.block.index, [&](const BlockBorder& border, Index3 offset) {
    gradients.remove(border, offset);
  });
  return points;
}

}  // namespace isosplat
