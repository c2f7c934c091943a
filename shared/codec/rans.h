#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosplat {

/// Four interleaved range asymmetric coders (rANS; J. Duda, "Asymmetric numeral systems", 2013)
/// over one run of little-endian 16-bit words, which is read backwards: symbol n belongs to state
/// n mod 4. Each state is in [2^16, 2^32) between symbols, so one word refills it.
inline constexpr int kRansStates = 4;
inline constexpr uint32_t kRansLow = 1u << 16;

/// A symbol that has `frequency` of the 2^scale_bits slots, from `start`, made ready to be encoded:
/// x becomes x + addend + ⌊x / frequency⌋ · complement, and the quotient is a product's upper half.
struct RansSymbol {
  uint64_t reciprocal;  ///< ⌈2^64 / frequency⌉: exact for every x < 2^32
  uint64_t limit;       ///< a state from here on gives away a word first
  uint32_t addend;
  uint32_t complement;

  RansSymbol() = default;
  /// frequency: 1 to 2^scale_bits; scale_bits ≤ 12.
  RansSymbol(uint32_t start, uint32_t frequency, uint32_t scale_bits)
      : reciprocal(~uint64_t{0} / frequency + 1),
        limit(uint64_t{frequency} << (32 - scale_bits)),
        addend(start),
        complement((1u << scale_bits) - frequency) {
    if (frequency > 1) return;
    // 2^64 does not fit; one less makes the quotient x − 1, and the addend makes up for it.
    reciprocal = ~uint64_t{0};
    addend += complement;
  }
};

/// Takes symbols in the order in which they will be decoded.
class RansEncoder {
 public:
  /// Starts anew, for at most so many symbols.
  void begin(size_t most_symbols) {
    if (symbols_.size() < most_symbols) {
      symbols_.resize(most_symbols);
      words_.resize(most_symbols + 2 * kRansStates);
    }
    count_ = 0;
  }

  /// The symbol must stay where it is until finish().
  void put(const RansSymbol& symbol) { symbols_[count_++] = &symbol; }

  /// Appends the words, the last one first, and the four states, state 0 last.
  void finish(std::vector<std::byte>& out) {
    // rANS encodes backwards, from the last symbol to the first.
    uint16_t* to = words_.data();
    const auto step = [&](uint32_t& x, const RansSymbol& symbol) {
      // Whether a word is due is close to random: arithmetic, not a branch.
      const uint32_t due = x >= symbol.limit;
      *to = static_cast<uint16_t>(x);
      to += due;
      x >>= due << 4;
      x += symbol.addend + upper_half(symbol.reciprocal, x) * symbol.complement;
    };
    uint32_t state[kRansStates] = {kRansLow, kRansLow, kRansLow, kRansLow};
    size_t i = count_;
    while (i % kRansStates) --i, step(state[i % kRansStates], *symbols_[i]);
    while (i) {
      for (size_t s = kRansStates; s-- > 0;) step(state[s], *symbols_[--i]);
    }
    for (size_t s = kRansStates; s-- > 0;) {
      *to++ = static_cast<uint16_t>(state[s]);
      *to++ = static_cast<uint16_t>(state[s] >> 16);
    }
    const auto* words = reinterpret_cast<const std::byte*>(words_.data());
    out.insert(out.end(), words, reinterpret_cast<const std::byte*>(to));
  }

 private:
  static uint32_t upper_half(uint64_t a, uint32_t b) {
    return static_cast<uint32_t>((((a & 0xffffffff) * b >> 32) + (a >> 32) * b) >> 32);
  }

  std::vector<const RansSymbol*> symbols_;
  std::vector<uint16_t> words_;
  size_t count_ = 0;
};

/// Does not check bounds: 2 bytes before position() must be readable for each symbol, and the
/// caller looks at position() often enough. Made to live in registers: copy it into a local
/// variable around a loop.
class RansDecoder {
 public:
  /// 16 bytes before `end` must be readable.
  explicit RansDecoder(const uint8_t* end) : at_(end - 4 * kRansStates) {
    std::memcpy(&next_, end - 4, 4);
    std::memcpy(&second_, end - 8, 4);
    std::memcpy(&third_, end - 12, 4);
    std::memcpy(&fourth_, end - 16, 4);
  }

  /// Decodes one symbol. `find(slot)` returns {start, frequency, symbol}.
  template <uint32_t kScaleBits, class Find>
  uint32_t get(Find find) {
    const uint32_t slot = next_ & ((1u << kScaleBits) - 1);
    const auto found = find(slot);
    const uint32_t x = found.frequency * (next_ >> kScaleBits) + slot - found.start;
    uint16_t word;
    std::memcpy(&word, at_ - 2, 2);
    // Whether a word is needed is close to random: arithmetic, not a branch.
    const uint32_t low = x < kRansLow;
    next_ = second_;
    second_ = third_;
    third_ = fourth_;
    fourth_ = x << (low << 4) | (word & (0 - low));
    at_ -= low << 1;
    return found.symbol;
  }

  const uint8_t* position() const { return at_; }

  /// All states lie where a decoder can be, so that x ≥ 2^16 holds from the first symbol on.
  bool starts_well() const {
    return next_ >= kRansLow && second_ >= kRansLow && third_ >= kRansLow && fourth_ >= kRansLow;
  }

  /// All states are back where the encoder began.
  bool ends_well() const {
    return next_ == kRansLow && second_ == kRansLow && third_ == kRansLow && fourth_ == kRansLow;
  }

 private:
  const uint8_t* at_;
  uint32_t next_, second_, third_, fourth_;  ///< the states, in the order of their turns
};

}  // namespace isosplat
