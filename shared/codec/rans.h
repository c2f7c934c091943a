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

/// Takes symbols in the order in which they will be decoded.
class RansEncoder {
 public:
  /// Starts anew, for at most so many symbols.
  void begin(size_t most_symbols) {
    if (symbols_.size() < most_symbols) symbols_.resize(most_symbols);
    count_ = 0;
  }

  /// A symbol that has `frequency` of the 2^scale_bits slots, from `start`. frequency ≥ 1,
  /// scale_bits ≤ 12.
  void put(uint32_t start, uint32_t frequency, uint32_t scale_bits) {
    symbols_[count_++] = start | frequency << 12 | scale_bits << 25;
  }

  /// Appends the words, the last one first, and the four states, state 0 last.
  void finish(std::vector<std::byte>& out) {
    // rANS encodes backwards, from the last symbol to the first.
    words_.clear();
    std::array<uint32_t, kRansStates> state;
    state.fill(kRansLow);
    for (size_t i = count_; i-- > 0;) {
      const uint32_t start = symbols_[i] & 0xfff, frequency = symbols_[i] >> 12 & 0x1fff;
      const uint32_t scale_bits = symbols_[i] >> 25;
      uint32_t& x = state[i % kRansStates];
      if (x >> (32 - scale_bits) >= frequency) {
        words_.push_back(static_cast<uint16_t>(x));
        x >>= 16;
      }
      const uint32_t quotient = x / frequency;
      x = (quotient << scale_bits) + (x - quotient * frequency) + start;
    }
    for (size_t i = kRansStates; i-- > 0;) {
      words_.push_back(static_cast<uint16_t>(state[i]));
      words_.push_back(static_cast<uint16_t>(state[i] >> 16));
    }
    const size_t at = out.size();
    out.resize(at + words_.size() * 2);
    std::byte* to = out.data() + at;
    for (const uint16_t word : words_) {
      *to++ = static_cast<std::byte>(word);
      *to++ = static_cast<std::byte>(word >> 8);
    }
  }

 private:
  std::vector<uint32_t> symbols_;  ///< start | frequency << 12 | scale bits << 25
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
