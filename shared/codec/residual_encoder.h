#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/codec/bit_stream.h"
#include "shared/codec/chunk_header.h"
#include "shared/codec/rans.h"
#include "shared/codec/residual_model.h"

namespace isosplat {

/// Collects a chunk's residuals, finds the models that suit them, and encodes them.
class ResidualEncoder {
 public:
  ResidualEncoder();

  /// Starts anew, for at most so many residuals.
  void begin(size_t most_residuals);

  /// Residuals in coding order.
  void add(uint32_t folded, int32_t key) {
    residuals_[size_++] = folded | static_cast<uint32_t>(key) << kFoldedBits;
    ++count_[key];
    sum_[key] += folded;
  }

  /// Sets where levels begin, and each context's model: the shift by the mean, the shape by its
  /// cost. header.levels.merge is given.
  void choose_models(ChunkHeader& header) const;

  /// With the header that choose_models() has set.
  void put(const ChunkHeader& header, RansEncoder& rans, BitWriter& bits) const;

 private:
  static constexpr uint32_t kFoldedBits = 18;
  static constexpr uint32_t kFoldedMask = (1u << kFoldedBits) - 1;

  RansSymbol symbol_[kShapes][kTokens];
  uint32_t cost_[kShapes][kTokens];  ///< in 1/256 bit

  std::vector<uint32_t> residuals_;  ///< folded | key << kFoldedBits
  size_t size_ = 0;
  uint32_t count_[kKeys];
  uint64_t sum_[kKeys];  ///< of the folded residuals
};

}  // namespace isosplat
