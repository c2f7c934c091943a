#include "shared/core/preprocess/block_storage_weight.h"

#include <algorithm>

#include "shared/core/base/portable_math.h"

namespace isosplat {
namespace {

/// Increases λ at levels ≥ 1, so that their blocks are cut into fewer bands: viewers read coarse
/// levels first, and the coarsest whole. Measured on engine (size of the store relative to the
/// voxels; bytes of coarse levels for an isovalue on average): 0.65 and 280 KB with a factor of 4,
/// 0.68 and 257 KB with 2.
constexpr double kCoarseStorageWeightFactor = 2;

/// Reduces λ in blocks with few cells that are ever active, because storing these in several bands
/// is cheap: λ is multiplied by the share of such cells to this power. Measured on aneurysm with λ
/// = 0.1 (size of level 0 relative to the voxels; bytes for an isovalue): 0.10 and 214 KB with
/// power 0, 0.19 and 187 KB with 0.75, 0.23 and 186 KB with 1. Engine, whose cells are all active,
/// does not change.
constexpr double kOccupancyPower = 0.75;

}  // namespace

BandOptions block_options(const BandOptions& options, uint32_t level, size_t active_cells,
                          size_t cells) {
  BandOptions result = options;
  const double occupancy =
      static_cast<double>(active_cells) / static_cast<double>(std::max<size_t>(1, cells));
  result.storage_weight *= portable::pow(occupancy, kOccupancyPower);
  if (level > 0) result.storage_weight *= kCoarseStorageWeightFactor;
  return result;
}

}  // namespace isosplat
