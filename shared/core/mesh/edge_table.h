#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace isosplat {

/// Numbers of lattice edges, by LatticeEdge::key: a hash table with open addressing. Entries are
/// not removed.
class EdgeTable {
 public:
  /// The number of an edge, or null.
  const uint32_t* find(uint64_t key) const {
    if (entries_.empty()) return nullptr;
    const Entry& entry = entries_[slot_of(key)];
    return entry.key_plus_one == 0 ? nullptr : &entry.number;
  }

  /// Returns the number of an edge, and whether the edge is new. A new edge gets the given number.
  std::pair<uint32_t, bool> emplace(uint64_t key, uint32_t number) {
    if (2 * (count_ + 1) > entries_.size()) grow();
    Entry& entry = entries_[slot_of(key)];
    if (entry.key_plus_one != 0) return {entry.number, false};
    entry = {key + 1, number};
    ++count_;
    return {number, true};
  }

 private:
  struct Entry {
    uint64_t key_plus_one = 0;  ///< 0: the entry is free
    uint32_t number = 0;
  };

  /// The index of the key's entry, or of the free entry where it would be inserted.
  size_t slot_of(uint64_t key) const {
    // The upper bits of a product with an odd number depend on all bits of the key.
    const int shift = 64 - std::countr_zero(entries_.size());
    size_t slot = static_cast<size_t>(key * 0x9E3779B97F4A7C15u >> shift);
    while (entries_[slot].key_plus_one != 0 && entries_[slot].key_plus_one != key + 1) {
      slot = (slot + 1) & (entries_.size() - 1);
    }
    return slot;
  }

  void grow() {
    const std::vector<Entry> old =
        std::exchange(entries_, std::vector<Entry>(entries_.empty() ? 1024 : 2 * entries_.size()));
    for (const Entry& entry : old) {
      if (entry.key_plus_one != 0) entries_[slot_of(entry.key_plus_one - 1)] = entry;
    }
  }

  std::vector<Entry> entries_;  ///< a power of two of them, at least half of them free
  size_t count_ = 0;
};

}  // namespace isosplat
