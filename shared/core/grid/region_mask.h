#pragma once

#include <array>
#include <cstdint>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// Regions of a block along each axis: a block's 64³ cells form 8×8×8 regions of 8³ cells each. A
/// region covers the same part of the volume as a block three levels finer.
inline constexpr int32_t kBlockRegions = 8;

/// The difference in level between a block and the blocks that its regions cover.
inline constexpr uint32_t kRegionLevels = 3;

/// A set of a block's regions. Region (x, y, z) is bit x + 8·y of slice z.
struct RegionMask {
  /// The representation for the GPU and JavaScript: the slices, low halves first.
  using Words = std::array<uint32_t, 2 * kBlockRegions>;

  std::array<uint64_t, kBlockRegions> slices{};

  static RegionMask all() {
    RegionMask mask;
    mask.slices.fill(~uint64_t{0});
    return mask;
  }

  /// The regions that a descendant covers, `levels` levels finer. `index`: its index among the
  /// descendants of that level, 0 ≤ index < 2^levels. Requires levels ≤ kRegionLevels.
  static RegionMask of_block_below(Index3 index, uint32_t levels) {
    const int32_t size = kBlockRegions >> levels;
    const uint64_t row = ((uint64_t{1} << size) - 1) << (index.x * size);
    uint64_t slice = 0;
    for (int32_t y = 0; y < size; ++y) slice |= row << (8 * (index.y * size + y));
    RegionMask mask;
    for (int32_t z = 0; z < size; ++z) {
      mask.slices[static_cast<size_t>(index.z * size + z)] = slice;
    }
    return mask;
  }

  static RegionMask from_words(const uint32_t* words) {
    RegionMask mask;
    for (size_t z = 0; z < mask.slices.size(); ++z) {
      mask.slices[z] = words[2 * z] | uint64_t{words[2 * z + 1]} << 32;
    }
    return mask;
  }
  Words words() const {
    Words result;
    for (size_t z = 0; z < slices.size(); ++z) {
      result[2 * z] = static_cast<uint32_t>(slices[z]);
      result[2 * z + 1] = static_cast<uint32_t>(slices[z] >> 32);
    }
    return result;
  }

  bool contains(Index3 region) const {
    return slices[static_cast<size_t>(region.z)] >> (region.x + 8 * region.y) & 1;
  }
  void insert(Index3 region) {
    slices[static_cast<size_t>(region.z)] |= uint64_t{1} << (region.x + 8 * region.y);
  }

  bool any() const {
    uint64_t found = 0;
    for (const uint64_t slice : slices) found |= slice;
    return found != 0;
  }

  RegionMask& operator&=(const RegionMask& other) {
    for (size_t z = 0; z < slices.size(); ++z) slices[z] &= other.slices[z];
    return *this;
  }
  RegionMask& operator|=(const RegionMask& other) {
    for (size_t z = 0; z < slices.size(); ++z) slices[z] |= other.slices[z];
    return *this;
  }
  /// Removes the other's regions.
  RegionMask& operator-=(const RegionMask& other) {
    for (size_t z = 0; z < slices.size(); ++z) slices[z] &= ~other.slices[z];
    return *this;
  }

  friend bool operator==(const RegionMask&, const RegionMask&) = default;
};

}  // namespace isosplat
