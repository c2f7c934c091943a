#include "shared/render/passes/lattice_regions.h"

#include <algorithm>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

// Regions of a volume along an axis need fewer bits: a level has at most 2³¹ cells.
constexpr int kKeyBits = 21;

uint64_t key_of(Index3 region) {
  return uint64_t(region.x) | uint64_t(region.y) << kKeyBits | uint64_t(region.z) << 2 * kKeyBits;
}

Index3 region_of(uint64_t key) {
  constexpr uint64_t kMask = (uint64_t{1} << kKeyBits) - 1;
  return {static_cast<int32_t>(key & kMask), static_cast<int32_t>(key >> kKeyBits & kMask),
          static_cast<int32_t>(key >> 2 * kKeyBits)};
}

bool is_between(Index3 at, Index3 low, Index3 high) {
  return at.x >= low.x && at.y >= low.y && at.z >= low.z && at.x <= high.x && at.y <= high.y &&
         at.z <= high.z;
}

}  // namespace

void LatticeRegions::set_chunks(uint32_t level, std::vector<LatticeChunk> chunks, FreePages& free) {
  const auto by_serial = [](const LatticeChunk& a, const LatticeChunk& b) {
    return a.serial < b.serial;
  };
  std::sort(chunks.begin(), chunks.end(), by_serial);
  if (level != level_) clear(free);
  level_ = level;
  if (chunks == chunks_) return;
  const auto drop_missing = [&](const auto& some, const auto& others) {
    for (const LatticeChunk& chunk : some) {
      const auto [first, last] = std::equal_range(others.begin(), others.end(), chunk, by_serial);
      if (first == last || !(*first == chunk)) drop_around(chunk, free);
    }
  };
  drop_missing(chunks, chunks_);
  drop_missing(chunks_, chunks);
  chunks_ = std::move(chunks);
}

void LatticeRegions::begin(Index3 low, Index3 size) {
  low_ = low;
  size_ = size;
  table_.assign(size_t(size.x) * size_t(size.y) * size_t(size.z), 0);
  new_pages_.clear();
  needed_ = 0;
}

void LatticeRegions::need(Index3 low, Index3 high) {
  for (int32_t z = low.z; z <= high.z; ++z) {
    for (int32_t y = low.y; y <= high.y; ++y) {
      for (int32_t x = low.x; x <= high.x; ++x) {
        uint32_t& entry = table_[index_in_table({x, y, z})];
        needed_ += entry == 0;
        entry = LATTICE_NEW_PAGE;
      }
    }
  }
}

bool LatticeRegions::assign(FreePages& free) {
  const auto needed_entry = [this](uint64_t key) -> uint32_t* {
    const Index3 region = region_of(key);
    if (!is_in_table(region)) return nullptr;
    uint32_t& entry = table_[index_in_table(region)];
    return entry == 0 ? nullptr : &entry;
  };
  const auto known = std::count_if(pages_.begin(), pages_.end(), [&](const auto& entry) {
    return needed_entry(entry.first) != nullptr;
  });
  const size_t missing = needed_ - static_cast<size_t>(known);
  if (missing > free.size()) drop_unneeded(free);
  if (missing > free.size()) {
    clear(free);
    return false;
  }
  for (const auto& [key, page] : pages_) {
    if (uint32_t* entry = needed_entry(key)) *entry = page;
  }
  size_t index = 0;
  for (int32_t z = 0; z < size_.z; ++z) {
    for (int32_t y = 0; y < size_.y; ++y) {
      for (int32_t x = 0; x < size_.x; ++x, ++index) {
        if (table_[index] != LATTICE_NEW_PAGE) continue;
        const uint32_t page = free.back();
        free.pop_back();
        pages_.emplace(key_of({low_.x + x, low_.y + y, low_.z + z}), page);
        table_[index] = page | LATTICE_NEW_PAGE;
        new_pages_.push_back(page);
      }
    }
  }
  std::sort(new_pages_.begin(), new_pages_.end());
  return true;
}

bool LatticeRegions::has_new(Index3 low, Index3 high) const {
  for (int32_t z = low.z; z <= high.z; ++z) {
    for (int32_t y = low.y; y <= high.y; ++y) {
      for (int32_t x = low.x; x <= high.x; ++x) {
        const Index3 region{x, y, z};
        if (is_in_table(region) && table_[index_in_table(region)] & LATTICE_NEW_PAGE) return true;
      }
    }
  }
  return false;
}

void LatticeRegions::clear(FreePages& free) {
  for (const auto& [key, page] : pages_) free.push_back(page);
  pages_.clear();
}

/// Cells of a block contribute to the lattice points up to the far border of the block, which are
/// the first ones of the next regions.
void LatticeRegions::drop_around(const LatticeChunk& chunk, FreePages& free) {
  const Index3 low = chunk.first_region;
  const Index3 high{low.x + kBlockRegions, low.y + kBlockRegions, low.z + kBlockRegions};
  std::erase_if(pages_, [&](const auto& entry) {
    if (!is_between(region_of(entry.first), low, high)) return false;
    free.push_back(entry.second);
    return true;
  });
}

void LatticeRegions::drop_unneeded(FreePages& free) {
  std::erase_if(pages_, [&](const auto& entry) {
    const Index3 region = region_of(entry.first);
    if (is_in_table(region) && table_[index_in_table(region)] != 0) return false;
    free.push_back(entry.second);
    return true;
  });
}

bool LatticeRegions::is_in_table(Index3 region) const {
  return is_between(region, low_,
                    {low_.x + size_.x - 1, low_.y + size_.y - 1, low_.z + size_.z - 1});
}

size_t LatticeRegions::index_in_table(Index3 region) const {
  const auto x = size_t(region.x - low_.x), y = size_t(region.y - low_.y);
  const auto z = size_t(region.z - low_.z);
  return x + size_t(size_.x) * (y + size_t(size_.y) * z);
}

}  // namespace isosplat::render
