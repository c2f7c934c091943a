#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/core/codec/bit_stream.h"
#include "shared/core/codec/chunk_header.h"
#include "shared/core/codec/rans.h"
#include "shared/core/codec/residual_model.h"

namespace isosplat {

/// Collects a chunk's residuals, chooses the models that encode them in the fewest bits, and
/// encodes them.
class ResidualEncoder {
 public:
  static constexpr size_t kSlack = 16;  ///< entries after end() that may be overwritten

  ResidualEncoder();

  /// Starts a new chunk of at most `max_residuals` residuals.
  void begin(size_t max_residuals);

  /// The address for the next residuals, each as residual_entry(), in coding order. set_end()
  /// states the end of the written entries.
  uint32_t* end() { return residuals_.data() + size_; }
  void set_end(const uint32_t* end) { size_ = static_cast<size_t>(end - residuals_.data()); }

  /// Sets header.levels.base and the model of each context: the one that needs the fewest bits,
  /// among those whose shift suits the mean residual. header.levels.merge must be set.
  /// has_intervals: whether the chunk has intervals. Returns the number of raw bits that put() will
  /// write.
  size_t choose_models(ChunkHeader& header, bool has_intervals);

  /// Encodes the residuals with the header that choose_models() has set, from the last to the
  /// first, as rANS requires.
  void put(const ChunkHeader& header, RansEncoder& rans, BackwardBitWriter& bits) const;

 private:
  /// Bins of folded residuals for the histogram from which models are chosen, as fine as the tokens
  /// of any model: one for each number from 0 to 15, then eight for each power of two up to 2^17,
  /// which exceeds all folded residuals.
  static constexpr uint32_t kBins = 16 + 8 * 13;
  static uint32_t bin_of(uint32_t folded);

  /// The token of each bin, for each shift of a model.
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
