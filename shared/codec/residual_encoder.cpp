#include "shared/codec/residual_encoder.h"

#include <array>
#include <utility>

namespace isosplat {
namespace {

/// −log2(frequency / 2048) in 1/256 bit, by integers, so that it is the same everywhere.
uint32_t cost_of(uint32_t frequency) {
  uint64_t x = uint64_t{frequency} << 32;
  uint32_t log = 0;
  while (x >= uint64_t{2} << 32) x >>= 1, log += 256;
  for (uint32_t bit = 128; bit; bit >>= 1) {
    const uint64_t root = x >> 16;
    x = root * root;
    if (x >= uint64_t{2} << 32) x >>= 1, log += bit;
  }
  return 11 * 256 - log;
}

}  // namespace

ResidualEncoder::ResidualEncoder() {
  for (int shape = 0; shape < kShapes; ++shape) {
    uint16_t frequencies[kTokens];
    read_distribution(kTokenTable[shape], kTokens, kTokenTotal, frequencies);
    uint32_t start = 0;
    for (int token = 0; token < kTokens; ++token) {
      symbol_[shape][token] = RansSymbol(start, frequencies[token], 11);
      cost_[shape][token] = cost_of(frequencies[token]);
      start += frequencies[token];
    }
  }
}

void ResidualEncoder::begin(size_t most_residuals) {
  if (residuals_.size() < most_residuals) residuals_.resize(most_residuals);
  size_ = 0;
  std::fill_n(count_, kKeys, 0);
  std::fill_n(sum_, kKeys, 0);
}

void ResidualEncoder::choose_models(ChunkHeader& header) const {
  const size_t few = size_ / 16;
  size_t below = 0;
  header.levels.base = 0;
  for (; header.levels.base < 15; ++header.levels.base) {
    for (int group = 0; group < kGroups; ++group) {
      below += count_[residual_key(header.levels.base, group)];
    }
    if (below > few) break;
  }

  std::array<uint32_t, kKeys> context_of;
  std::array<uint64_t, kContexts> sum{};
  std::array<uint32_t, kContexts> count{}, shift{};
  for (int32_t key = 0; key < kKeys; ++key) {
    const auto context = static_cast<uint32_t>(header.levels.context_of_key(key));
    context_of[key] = context;
    sum[context] += sum_[key];
    count[context] += count_[key];
  }
  for (int c = 0; c < kContexts; ++c) {
    // A mean of nine is where the broadest plain distribution ends.
    while (shift[c] < kMaxShift && sum[c] > uint64_t{count[c]} * 9 << shift[c]) ++shift[c];
  }

  std::array<std::array<uint32_t, kTokens>, kContexts> histogram{};
  for (size_t i = 0; i < size_; ++i) {
    const uint32_t c = context_of[residuals_[i] >> kFoldedBits];
    ++histogram[c][token_of((residuals_[i] & kFoldedMask) >> shift[c]).token];
  }
  for (int c = 0; c < kContexts; ++c) {
    header.model[c] = kNoModel;
    uint64_t best = ~uint64_t{0};
    for (uint32_t m = 0; m < kModels && count[c]; ++m) {
      const Model model = model_of(m);
      if (model.shift != shift[c]) continue;
      uint64_t cost = 0;
      for (int t = 0; t < kTokens; ++t) {
        cost += uint64_t{histogram[c][t]} * cost_[model.shape][t];
      }
      if (cost < best) best = cost, header.model[c] = static_cast<uint8_t>(m);
    }
  }
}

void ResidualEncoder::put(const ChunkHeader& header, RansEncoder& rans, BitWriter& bits) const {
  struct KeyModel {
    const RansSymbol* symbols;
    uint32_t shift;
  };
  std::array<KeyModel, kKeys> models{};
  for (int32_t key = 0; key < kKeys; ++key) {
    if (!count_[key]) continue;
    const Model model = model_of(header.model[header.levels.context_of_key(key)]);
    models[key] = {symbol_[model.shape], model.shift};
  }
  // Bytes may alias anything: only local variables stay in registers.
  BitWriter local_bits = std::move(bits);
  RansEncoder local_rans = std::move(rans);
  for (size_t i = 0; i < size_; ++i) {
    const KeyModel model = models[residuals_[i] >> kFoldedBits];
    const uint32_t folded = residuals_[i] & kFoldedMask;
    const Token token = token_of(folded >> model.shift);
    local_rans.put(model.symbols[token.token]);
    const uint32_t raw_bits = token.raw_bits + model.shift;
    local_bits.put(folded & ((1u << raw_bits) - 1), raw_bits);
  }
  bits = std::move(local_bits);
  rans = std::move(local_rans);
}

}  // namespace isosplat
