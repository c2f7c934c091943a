#include "shared/core/codec/residual_encoder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace isosplat {
namespace {

constexpr uint32_t kTokenBits = 11;
static_assert(kTokenTotal == 1u << kTokenBits);

/// −log2(frequency / 2048) in units of 1/256 bit. Integer arithmetic, so that all machines get the
/// same result.
uint32_t cost_of(uint32_t frequency) {
  uint64_t x = uint64_t{frequency} << 32;
  uint32_t log = 0;
  while (x >= uint64_t{2} << 32) x >>= 1, log += 256;
  for (uint32_t bit = 128; bit; bit >>= 1) {
    const uint64_t root = x >> 16;
    x = root * root;
    if (x >= uint64_t{2} << 32) x >>= 1, log += bit;
  }
  return kTokenBits * 256 - log;
}

/// ⌊log2(number)⌋ for 1 ≤ number < 2^24. Uses the exponent of a float, because not all instruction
/// sets count leading zeros of vectors.
uint32_t bits_beyond_one(uint32_t number) {
  const auto real = static_cast<float>(static_cast<int32_t>(number));
  uint32_t bits;
  std::memcpy(&bits, &real, sizeof bits);
  return (bits >> 23) - 127;
}

/// The least folded residual of a bin.
uint32_t min_of_bin(uint32_t bin) {
  return bin < 16 ? bin : (8 + (bin & 7)) << ((bin >> 3) - 1);
}

}  // namespace

uint32_t ResidualEncoder::bin_of(uint32_t folded) {
  // The exponent of a float and the first three bits of its mantissa, so that the compiler can
  // vectorise the loop that calls this.
  const auto number = static_cast<float>(static_cast<int32_t>(folded));
  uint32_t bits;
  std::memcpy(&bits, &number, sizeof bits);
  const auto fine = static_cast<int32_t>(bits >> 20) - (((127 + 4) << 3) - 16);
  return static_cast<uint32_t>(std::max(fine, std::min(static_cast<int32_t>(folded), 15)));
}

ResidualEncoder::BinTokens::BinTokens() {
  for (uint32_t shift = 0; shift <= kMaxShift; ++shift) {
    for (uint32_t bin = 0; bin < kBins; ++bin) {
      token[shift][bin] = static_cast<uint8_t>(token_of(min_of_bin(bin) >> shift).token);
    }
  }
}

ResidualEncoder::ResidualEncoder() {
  for (int shape = 0; shape < kShapes; ++shape) {
    uint16_t frequencies[kTokens];
    read_distribution(kTokenTable[shape], kTokens, kTokenTotal, frequencies);
    uint32_t start = 0;
    for (int token = 0; token < kTokens; ++token) {
      symbol_[shape][token] = RansSymbol(start, frequencies[token], kTokenBits);
      cost_[shape][token] = cost_of(frequencies[token]);
      start += frequencies[token];
    }
  }
}

void ResidualEncoder::begin(size_t max_residuals) {
  if (residuals_.size() < max_residuals + kSlack) {
    residuals_.clear();  // nothing to copy
    residuals_.resize(max_residuals + max_residuals / 2 + kSlack);
  }
  size_ = 0;
}

/// Counts the residuals of each key below `keys` in each bin; larger keys do not occur.
void ResidualEncoder::count_bins(int32_t keys) {
  std::fill_n(&bins_[0][0], static_cast<uint32_t>(keys) * kBins, 0);
  uint32_t* const counts = &bins_[0][0];
  constexpr size_t kBatch = 512;
  uint16_t at[kBatch];
  for (size_t begin = 0; begin < size_; begin += kBatch) {
    const size_t count = std::min(kBatch, size_ - begin);
    const uint32_t* const entries = residuals_.data() + begin;
    // This loop is separate from the counting, so that the compiler vectorises it.
    for (size_t i = 0; i < count; ++i) {
      at[i] = static_cast<uint16_t>((entries[i] >> kFoldedBits) * kBins +
                                    bin_of(entries[i] & kFoldedMask));
    }
    for (size_t i = 0; i < count; ++i) ++counts[at[i]];
  }
}

ResidualEncoder::Choice ResidualEncoder::choose_model(const uint32_t* bins) const {
  uint64_t count = 0, sum = 0;
  for (uint32_t bin = 0; bin < kBins; ++bin) {
    count += bins[bin];
    sum += uint64_t{bins[bin]} * min_of_bin(bin);
  }
  // The broadest distribution without a shift suits a mean of 9: find the shift that brings the
  // mean below that, and try it and its neighbours.
  uint32_t middle = 0;
  while (middle < kMaxShift && sum > count * 9 << middle) ++middle;

  Choice best{kNoModel, 0};
  uint64_t best_cost = ~uint64_t{0};
  for (uint32_t shift = std::max(middle, 1u) - 1; shift <= std::min(middle + 1, kMaxShift);
       ++shift) {
    std::array<uint32_t, kTokens> tokens{};
    for (uint32_t bin = 0; bin < kBins; ++bin) tokens[bin_tokens_.token[shift][bin]] += bins[bin];
    uint64_t raw_bits = count * shift;
    for (uint32_t token = 16; token < kTokens; ++token) {
      raw_bits += uint64_t{tokens[token]} * (token - 12);
    }
    const auto [first, end] = models_of_shift(shift);
    for (uint32_t run = 0; run < kModels; run += kModelsPerRun) {
      for (uint32_t m = run + first; m < run + end; ++m) {
        const uint32_t* const costs = cost_[model_of(m).shape];
        uint64_t cost = raw_bits << 8;
        for (int token = 0; token < kTokens; ++token)
          cost += uint64_t{tokens[token]} * costs[token];
        if (cost < best_cost) best_cost = cost, best = {m, raw_bits};
      }
    }
  }
  return best;
}

size_t ResidualEncoder::choose_models(ChunkHeader& header, bool has_intervals) {
  const int32_t keys = (has_intervals ? kGroups : kIntervalMin) * kOctaves;
  count_bins(keys);
  std::array<size_t, kOctaves> octaves{};
  for (int32_t key = 0; key < keys; ++key) {
    for (const uint32_t count : bins_[key]) octaves[static_cast<size_t>(key % kOctaves)] += count;
  }
  // The lowest 1/16 of all residuals share level 0.
  header.levels.base = 0;
  for (size_t below = octaves[0]; header.levels.base < 15 && below <= size_ / 16;) {
    below += octaves[static_cast<size_t>(++header.levels.base)];
  }

  std::array<std::array<uint32_t, kBins>, kContexts> contexts{};
  std::array<size_t, kContexts> used{};
  for (int32_t key = 0; key < keys; ++key) {
    if (octaves[static_cast<size_t>(key % kOctaves)] == 0) continue;
    const auto c = static_cast<size_t>(header.levels.context_of_key(key));
    for (uint32_t bin = 0; bin < kBins; ++bin) {
      contexts[c][bin] += bins_[key][bin];
      used[c] += bins_[key][bin];
    }
  }
  size_t raw_bits = 0;
  for (size_t c = 0; c < kContexts; ++c) {
    header.model[c] = kNoModel;
    if (used[c] == 0) continue;
    const Choice choice = choose_model(contexts[c].data());
    header.model[c] = static_cast<uint8_t>(choice.model);
    raw_bits += choice.raw_bits;
  }
  return raw_bits;
}

void ResidualEncoder::put(const ChunkHeader& header, RansEncoder& rans,
                          BackwardBitWriter& bits) const {
  // For each key: the index of its model's first symbol, and the model's shift in the bits above.
  constexpr uint32_t kSymbolBits = 16;
  std::array<uint32_t, kKeys> models{};
  for (int32_t key = 0; key < kKeys; ++key) {
    const uint8_t m = header.model[header.levels.context_of_key(key)];
    if (m == kNoModel) continue;
    const Model model = model_of(m);
    models[static_cast<size_t>(key)] = model.shape * kTokens | model.shift << kSymbolBits;
  }
  // Stores of bytes may alias any object: only local copies stay in registers.
  BackwardBitWriter local_bits = std::move(bits);
  RansEncoder local_rans = rans;
  constexpr size_t kBatch = 512;
  uint32_t symbol[kBatch], raw[kBatch], raw_bits[kBatch];
  for (size_t end = size_, count; end > 0; end -= count) {
    // Only the batch encoded last may be incomplete, so groups of four never cross batches.
    count = std::min(end, kBatch);
    const uint32_t* const entries = residuals_.data() + end - count;
    // This loop is separate from the encoding, so that the compiler vectorises it.
    for (size_t i = 0; i < count; ++i) {
      const uint32_t model = models[entries[i] >> kFoldedBits], shift = model >> kSymbolBits;
      const uint32_t folded = entries[i] & kFoldedMask, q = folded >> shift;
      // token_of(): from 16 on, q is never below its token.
      const uint32_t token_bits = bits_beyond_one(q | 8);
      symbol[i] = (model & ((1u << kSymbolBits) - 1)) + std::min(q, token_bits + 12);
      raw_bits[i] = shift + (token_bits & -static_cast<uint32_t>(q >= 16));
      raw[i] = folded & ((1u << raw_bits[i]) - 1);
    }
    const RansSymbol* const symbols = &symbol_[0][0];
    size_t i = count;
    for (; i >= kRansStates; i -= kRansStates) {
      for (size_t k = 1; k <= kRansStates; ++k) local_rans.put<kTokenBits>(symbols[symbol[i - k]]);
    }
    for (; i > 0; --i) local_rans.put<kTokenBits>(symbols[symbol[i - 1]]);
    const auto put_two = [&](size_t first) {
      local_bits.put(raw[first] | uint64_t{raw[first + 1]} << raw_bits[first],
                     raw_bits[first] + raw_bits[first + 1]);
    };
    for (i = count; i >= 4; i -= 4) {
      // Four residuals almost always fit into one put().
      const size_t a = i - 4, c = i - 2;
      const uint32_t bits_a = raw_bits[a] + raw_bits[a + 1], bits_c = raw_bits[c] + raw_bits[c + 1];
      if (bits_a + bits_c > BackwardBitWriter::kMaxBits) {
        put_two(c), put_two(a);
        continue;
      }
      const uint64_t two_a = raw[a] | uint64_t{raw[a + 1]} << raw_bits[a];
      const uint64_t two_c = raw[c] | uint64_t{raw[c + 1]} << raw_bits[c];
      local_bits.put(two_a | two_c << bits_a, bits_a + bits_c);
    }
    for (; i > 0; --i) local_bits.put(raw[i - 1], raw_bits[i - 1]);
  }
  bits = std::move(local_bits);
  rans = local_rans;
}

}  // namespace isosplat
