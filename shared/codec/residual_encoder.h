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
  static constexpr size_t kSlack = 16;  ///< entries beyond the last that may be overwritten

  ResidualEncoder();

  /// Starts a new chunk of at most `max_residuals` residuals.
  void begin(size_t max_residuals);

  /// Room for the next residuals in coding order, and kSlack more, to be filled with
  /// residual_entry() as far as set_end() says.
  uint32_t* end() { return residuals_.data() + size_; }
  void set_end(const uint32_t* end) { size_ = static_cast<size_t>(end - residuals_.data()); }

  /// Sets where levels begin, and each context's model: the cheapest of those with about the right
  /// number of raw bits. header.levels.merge is given. has_intervals: of the chunk. Returns how
  /// many raw bits put() will write.
  size_t choose_models(ChunkHeader& header, bool has_intervals);

  /// Encodes backwards, from the last residual to the first, with the header that choose_models()
  /// has set.
  void put(const ChunkHeader& header, RansEncoder& rans, BackwardBitWriter& bits) const;

 private:
  /// Bins of folded residuals, as fine as any model's tokens: 0 to 15 are themselves, then come
  /// eight for each power of two below 2^17, which no folded residual reaches.
  static constexpr uint32_t kBins = 16 + 8 * 13;
  static uint32_t bin_of(uint32_t folded);

  /// Of each model shift, the tokens that bins become.
  struct BinTokens {
    uint8_t token[kMaxShift + 1][kBins];
    BinTokens();
  };

  struct Choice {
    uint32_t model;
    uint64_t raw_bits;
  };
  void count_bins(int32_t keys);
  Choice choose_model(const uint32_t* bins) const;

  RansSymbol symbol_[kShapes][kTokens];
  uint32_t cost_[kShapes][kTokens];  ///< in 1/256 bit
  BinTokens bin_tokens_;

  std::vector<uint32_t> residuals_;  ///< residual_entry()
  size_t size_ = 0;
  uint32_t bins_[kKeys][kBins];  ///< residuals in each bin
};

}  // namespace isosplat
