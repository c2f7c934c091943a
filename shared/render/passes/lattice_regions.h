#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/grid/region_mask.h"

namespace isosplat::render {

/// Pages of a texture that are not in use. Page 0 is never among them: it stays zero.
using FreePages = std::vector<uint32_t>;

/// A chunk whose cells contribute to the gradients at lattice points.
struct LatticeChunk {
  uint64_t serial = 0;  ///< SampleRange::serial
  Index3 first_region;  ///< of its block
  RegionMask regions;   ///< in which it is drawn

  friend bool operator==(const LatticeChunk&, const LatticeChunk&) = default;
};

/// Which regions of the lattice of a level have a page with the gradients at their lattice points.
/// A region has 8³ lattice points: the low corners of the cells of a region of a block. Regions are
/// counted from the volume's corner.
class LatticeRegions {
 public:
  /// Sets the level and the chunks that contribute, in any order. Pages at which another chunk
  /// contributes than before become free.
  void set_chunks(uint32_t level, std::vector<LatticeChunk> chunks, FreePages& free);

  /// Starts a list of the regions that are needed: a table of `size` regions from `low` on.
  void begin(Index3 low, Index3 size);
  /// Marks the regions low to high, inclusive, as needed. They must be in the table.
  void need(Index3 low, Index3 high);

  /// Gives a page to each needed region. If free pages do not suffice, those of regions that are
  /// not needed become free first. Returns false if there are too few: then all become free.
  bool assign(FreePages& free);

  /// After assign(): the number of each region's page in the table, x fastest; 0: none. Pages that
  /// are new have LATTICE_NEW_PAGE set.
  const std::vector<uint32_t>& table() const { return table_; }
  Index3 low() const { return low_; }
  Index3 size() const { return size_; }
  /// Whether one of the regions low to high, inclusive, has a new page.
  bool has_new(Index3 low, Index3 high) const;
  /// In ascending order.
  const std::vector<uint32_t>& new_pages() const { return new_pages_; }
  /// The number of needed regions.
  size_t needed() const { return needed_; }

  /// The pages of regions that are not needed become free.
  void drop_unneeded(FreePages& free);
  /// All pages become free.
  void clear(FreePages& free);

 private:
  void drop_around(const LatticeChunk& chunk, FreePages& free);
  bool is_in_table(Index3 region) const;
  size_t index_in_table(Index3 region) const;

  uint32_t level_ = 0;
  std::vector<LatticeChunk> chunks_;  // sorted by serial
  std::unordered_map<uint64_t, uint32_t> pages_;
  Index3 low_, size_;
  std::vector<uint32_t> table_;
  std::vector<uint32_t> new_pages_;
  size_t needed_ = 0;
};

}  // namespace isosplat::render
