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
/// x becomes x + start + ⌊x / frequency⌋ · complement.
struct RansSymbol {
  /// ⌈2^(32 + scale_bits) / frequency⌉. A state x is below frequency · 2^(32 − scale_bits) where it
  /// is divided: the product fits 64 bits, and its upper part is the exact quotient.
  uint64_t reciprocal;
  uint32_t limit;  ///< a state ≥ limit first writes a word
  uint16_t start;
  uint16_t complement;  ///< 2^scale_bits − frequency

  RansSymbol() = default;
  /// frequency: at least 1, less than 2^scale_bits; scale_bits ≤ 12.
  RansSymbol(uint32_t first_slot, uint32_t frequency, uint32_t scale_bits)
      : reciprocal(((uint64_t{1} << (32 + scale_bits)) + frequency - 1) / frequency),
        limit(frequency << (32 - scale_bits)),
        start(static_cast<uint16_t>(first_slot)),
        complement(static_cast<uint16_t>((1u << scale_bits) - frequency)) {}
};

/// rANS encodes backwards: the first symbol to put is the last one to decode. Copy it into a
/// local variable around a loop, so that it stays in registers.
class RansEncoder {
 public:
  /// Writes a word at most for each symbol, and 2 kRansStates at the end, from `to` on.
  explicit RansEncoder(uint16_t* to) : to_(to) {}

  template <uint32_t kScaleBits>
  void put(const RansSymbol& symbol) {
    uint32_t x = next_;
    // Whether a word is due is close to random: arithmetic, not a branch.
    const uint32_t due = x >= symbol.limit;
    *to_ = static_cast<uint16_t>(x);
    to_ += due;
    x >>= due << 4;
    const auto quotient = static_cast<uint32_t>(x * symbol.reciprocal >> (32 + kScaleBits));
    x += symbol.start + quotient * symbol.complement;
    next_ = second_;
    second_ = third_;
    third_ = fourth_;
    fourth_ = x;
  }

  /// Writes the four states, state 0 last, and returns the end of the words. They are stored in the
  /// order in which they came.
  uint16_t* finish() {
    // Symbol 0, which was put last, left its state in fourth_; symbol 1's is in third_.
    for (const uint32_t state : {next_, second_, third_, fourth_}) {
      *to_++ = static_cast<uint16_t>(state);
      *to_++ = static_cast<uint16_t>(state >> 16);
    }
    return to_;
  }

 private:
  uint16_t* to_;
  /// The states, in the order of their turns.
  uint32_t next_ = kRansLow, second_ = kRansLow, third_ = kRansLow, fourth_ = kRansLow;
};

/// A symbol and its slots.
struct FoundSymbol {
  uint32_t start, frequency, symbol;
};

/// Does not check bounds: 2 bytes before position() must be readable for each symbol, and the
/// caller must check position() regularly. Copy it into a local variable around a loop, so that it
/// stays in registers.
class RansDecoder {
 public:
  /// 16 bytes before `end` must be readable.
  explicit RansDecoder(const uint8_t* end) : at_(end - 4 * kRansStates) {
    std::memcpy(&next_, end - 4, 4);
    std::memcpy(&second_, end - 8, 4);
    std::memcpy(&third_, end - 12, 4);
    std::memcpy(&fourth_, end - 16, 4);
  }

  /// Decodes one symbol. `find(slot)` returns the FoundSymbol that has the slot.
  template <uint32_t kScaleBits, class Find>
  uint32_t get(Find find) {
    const uint32_t slot = next_ & ((1u << kScaleBits) - 1);
    const auto found = find(slot);
    const uint32_t x = found.frequency * (next_ >> kScaleBits) + slot - found.start;
    uint16_t word;
    std::memcpy(&word, at_ - 2, 2);
    // Whether a word is needed is close to random: arithmetic, not a branch. −1 if it is, else 0:
    const auto low = static_cast<ptrdiff_t>((int64_t{x} - kRansLow) >> 63);
    next_ = second_;
    second_ = third_;
    third_ = fourth_;
    fourth_ = x << (low & 16) | (word & static_cast<uint32_t>(low));
    at_ += 2 * low;
    return found.symbol;
  }

  const uint8_t* position() const { return at_; }

  /// Whether all states are at least 2^16, as decoding requires.
  bool has_valid_initial_states() const {
    return next_ >= kRansLow && second_ >= kRansLow && third_ >= kRansLow && fourth_ >= kRansLow;
  }

  /// Whether all states have the encoder's initial value.
  bool has_valid_final_states() const {
    return next_ == kRansLow && second_ == kRansLow && third_ == kRansLow && fourth_ == kRansLow;
  }

 private:
  const uint8_t* at_;
  uint32_t next_, second_, third_, fourth_;  ///< the states, in the order of their turns
};

}  // namespace isosplat
