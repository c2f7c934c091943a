#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosplat {

/// Bits, most significant first. A chunk's bits run backwards from its last byte, towards the rANS
/// words that run forwards from its first: so neither needs a length.
class BitWriter {
 public:
  void clear() { bytes_.clear(), held_ = 0, hold_ = 0; }

  /// bits: 0 to 32, value < 2^bits.
  void put(uint32_t value, int bits) {
    hold_ = hold_ << bits | value;
    held_ += bits;
    while (held_ >= 8) {
      held_ -= 8;
      bytes_.push_back(static_cast<uint8_t>(hold_ >> held_));
    }
  }

  /// Fills the last byte with zero bits, and appends all bytes to `out`, the first one last.
  void finish(std::vector<std::byte>& out) {
    if (held_) put(0, 8 - held_);
    for (size_t i = bytes_.size(); i-- > 0;) out.push_back(std::byte{bytes_[i]});
  }

 private:
  std::vector<uint8_t> bytes_;
  uint64_t hold_ = 0;
  int held_ = 0;
};

/// Reads what BitWriter wrote. It does not check bounds: 8 bytes before the position must be
/// readable, and the caller looks at bytes_read() often enough.
class BitReader {
 public:
  explicit BitReader(const uint8_t* end) : end_(end) {}

  /// bits: 0 to 32.
  uint32_t get(uint32_t bits) {
    uint64_t word;
    std::memcpy(&word, end_ - 8 - (position_ >> 3), 8);
    const uint64_t value = (word << (position_ & 7)) >> 1 >> (63 - bits);
    position_ += bits;
    return static_cast<uint32_t>(value);
  }

  /// Bytes begun.
  size_t bytes_read() const { return (position_ + 7) >> 3; }

  /// Whether the rest of the last byte begun is zero.
  bool padding_is_zero() const {
    const auto rest = static_cast<uint32_t>(-position_ & 7);
    return BitReader(*this).get(rest) == 0;
  }

 private:
  const uint8_t* end_;
  size_t position_ = 0;
};

}  // namespace isosplat
