#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/grid/grid.h"
#include "shared/sampling/cell.h"
#include "shared/slabs/slab_planner.h"

namespace isosplat {

/// What the build learns of a volume on its way: how often each code occurs, and how many cells of
/// level 0 are active at each isovalue, and how steep they are. Sums of integers, so that the
/// result does not depend on who adds what.
class VolumeStatistics {
 public:
  VolumeStatistics();

  /// Counts codes (bytes where bits is 8). Missing voxels count only as missing.
  void add_codes(const void* codes, size_t count, uint8_t bits, bool has_missing);

  /// Adds a block of level 0, as the planner has counted it.
  void add_block(const SlabPlanner& planner, std::span<const CellInterval> intervals);

  void add(const VolumeStatistics& other);

  uint64_t missing() const { return missing_; }

  /// Of all voxels with a value; {0, 0} where there is none.
  CellInterval range() const;

  /// Voxels by value: `bins` equal bins over [range().min, range().max] in codes.
  std::vector<uint64_t> histogram(CellInterval range, uint32_t bins) const;

  /// Active cells of level 0 at the middle of each bin.
  std::vector<uint64_t> active_cells(CellInterval range, uint32_t bins) const;

  /// Isocodes, strongest first, at which the isosurface is steep for its size: peaks of the mean
  /// span of the active cells. At most `most`.
  std::vector<double> suggest(CellInterval range, size_t most) const;

 private:
  std::vector<uint64_t> voxels_, minima_, maxima_, spans_from_, spans_to_;  // per code
  uint64_t missing_ = 0;
};

}  // namespace isosplat
