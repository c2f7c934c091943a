#include "shared/core/preprocess/picked_levels.h"

#include <algorithm>

#include "shared/core/preprocess/coarse_voxels.h"

namespace isosplat {
namespace {

template <class T>
void pick_voxels(const Layer& layer, Index3 block, const CoarserLayer& coarser) {
  const LevelBox written = coarse_voxels_of(layer.grid, block);
  const Index3 last = layer.grid.cells, end = written.end();
  const auto* from = reinterpret_cast<const T*>(layer.voxels);
  auto* to = reinterpret_cast<T*>(coarser.voxels);
  for (int32_t z = written.first.z; z < end.z; ++z) {
    for (int32_t y = written.first.y; y < end.y; ++y) {
      for (int32_t x = written.first.x; x < end.x; ++x) {
        const Index3 finer{std::min(2 * x, last.x), std::min(2 * y, last.y),
                           std::min(2 * z, last.z)};
        to[coarser.voxel_box.at({x, y, z})] = from[layer.voxel_box.at(finer)];
      }
    }
  }
}

}  // namespace

void PickedLevels::coarsen_voxels(const Layer& layer, const GatheredBlock& block,
                                  const CoarserLayer& coarser) const {
  layer.bits == 8 ? pick_voxels<uint8_t>(layer, block.index, coarser)
                  : pick_voxels<uint16_t>(layer, block.index, coarser);
}

}  // namespace isosplat
