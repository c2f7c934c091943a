#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosplat {

/// Bits, least significant first, as a chunk begins with. They run towards the rANS words, which
/// run backwards from the chunk's last byte: so neither needs a length.
class BitWriter {
 public:
  /// Starts anew, for at most so many bits.
  void begin(size_t most_bits) {
    if (bytes_.size() < most_bits / 8 + 16) bytes_.resize(most_bits / 8 + 16);
    size_ = 0, held_ = 0, hold_ = 0;
  }

  /// bits: 0 to 32, value < 2^bits.
  void put(uint32_t value, uint32_t bits) {
    hold_ |= uint64_t{value} << held_;
    held_ += bits;
    std::memcpy(bytes_.data() + size_, &hold_, 8);
    size_ += held_ >> 3;
    hold_ >>= held_ & 56;
    held_ &= 7;
  }

  /// Fills the last byte with zero bits, and appends all bytes to `out`.
  void finish(std::vector<std::byte>& out) {
    if (held_) put(0, 8 - held_);
    out.insert(out.end(), bytes_.begin(), bytes_.begin() + static_cast<ptrdiff_t>(size_));
  }

 private:
  std::vector<std::byte> bytes_;
  size_t size_ = 0;
  uint64_t hold_ = 0;
  uint32_t held_ = 0;
};

/// Reads what BitWriter wrote. It does not check bounds: 8 bytes from the position must be
/// readable, and the caller looks at bytes_read() often enough.
class BitReader {
 public:
  explicit BitReader(const uint8_t* begin) : begin_(begin) {}

  /// bits: 0 to 32.
  uint32_t get(uint32_t bits) {
    uint64_t word;
    std::memcpy(&word, begin_ + (position_ >> 3), 8);
    const uint64_t value = word >> (position_ & 7) & ((uint64_t{1} << bits) - 1);
    position_ += bits;
    return static_cast<uint32_t>(value);
  }

  /// Bytes begun.
  size_t bytes_read() const { return (position_ + 7) >> 3; }

  /// One beyond the last byte begun.
  const uint8_t* position() const { return begin_ + bytes_read(); }

  /// Whether the rest of the last byte begun is zero.
  bool padding_is_zero() const {
    return BitReader(*this).get(static_cast<uint32_t>(-position_ & 7)) == 0;
  }

 private:
  const uint8_t* begin_;
  size_t position_ = 0;
};

}  // namespace isosplat
