#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosplat {

/// Four interleaved range asymmetric coders (rANS; J. Duda, "Asymmetric numeral systems", 2013)
/// over one run of little-endian 16-bit words: symbol n belongs to state n mod 4. Each state is in
/// [2^16, 2^32) between symbols, so one word refills it.
inline constexpr int kRansStates = 4;
inline constexpr uint32_t kRansLow = 1u << 16;

/// Takes symbols in the order in which they will be decoded.
class RansEncoder {
 public:
  void clear() { symbols_.clear(); }

  /// A symbol that has `frequency` of the 2^scale_bits slots, from `start`. frequency ≥ 1,
  /// scale_bits ≤ 12.
  void put(uint32_t start, uint32_t frequency, uint32_t scale_bits) {
    symbols_.push_back(start | frequency << 12 | scale_bits << 25);
  }

  /// Appends the four states and the words to `out`.
  void finish(std::vector<std::byte>& out) {
    // rANS encodes backwards: the last symbol first, words from the end.
    words_.clear();
    std::array<uint32_t, kRansStates> state;
    state.fill(kRansLow);
    for (size_t i = symbols_.size(); i-- > 0;) {
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
    for (const uint32_t x : state) {
      for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>(x >> shift));
    }
    const size_t at = out.size();
    out.resize(at + words_.size() * 2);
    std::byte* to = out.data() + at;
    for (size_t i = words_.size(); i-- > 0; to += 2) {
      to[0] = static_cast<std::byte>(words_[i]);
      to[1] = static_cast<std::byte>(words_[i] >> 8);
    }
  }

 private:
  std::vector<uint32_t> symbols_;  ///< start | frequency << 12 | scale bits << 25
  std::vector<uint16_t> words_;
};

/// Does not check bounds: 2 bytes at position() must be readable for each symbol, and the caller
/// looks at position() often enough.
class RansDecoder {
 public:
  /// 16 bytes at `bytes` must be readable.
  explicit RansDecoder(const uint8_t* bytes) : at_(bytes + 4 * kRansStates) {
    std::memcpy(state_.data(), bytes, 4 * kRansStates);
  }

  /// Decodes one symbol. `find(slot)` returns {start, frequency, symbol}.
  template <uint32_t kScaleBits, class Find>
  uint32_t get(Find find) {
    uint32_t& state = state_[turn_++ % kRansStates];
    uint32_t x = state;
    const uint32_t slot = x & ((1u << kScaleBits) - 1);
    const auto found = find(slot);
    x = found.frequency * (x >> kScaleBits) + slot - found.start;
    uint16_t word;
    std::memcpy(&word, at_, 2);
    const bool low = x < kRansLow;
    state = low ? x << 16 | word : x;
    at_ += low ? 2 : 0;
    return found.symbol;
  }

  const uint8_t* position() const { return at_; }

  /// All states lie where a decoder can be, so that x ≥ 2^16 holds from the first symbol on.
  bool starts_well() const {
    bool good = true;
    for (const uint32_t x : state_) good &= x >= kRansLow;
    return good;
  }

  /// All states are back where the encoder began.
  bool ends_well() const {
    bool good = true;
    for (const uint32_t x : state_) good &= x == kRansLow;
    return good;
  }

 private:
  const uint8_t* at_;
  std::array<uint32_t, kRansStates> state_;
  uint32_t turn_ = 0;
};

}  // namespace isosplat
