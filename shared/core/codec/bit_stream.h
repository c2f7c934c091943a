#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosplat {

/// Writes bits, least significant first. A chunk begins with them, and the rANS words run backwards
/// from its last byte. The two streams grow towards each other, so neither needs a length.
class BitWriter {
 public:
  /// Starts a new stream of at most `max_bits` bits.
  void begin(size_t max_bits) {
    if (bytes_.size() < max_bits / 8 + 16) bytes_.resize(max_bits / 8 + 16);
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

  /// Bits written so far.
  size_t size() const { return 8 * size_ + held_; }

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

/// Writes the bits that follow those of a BitWriter, last bits first: the order in which rANS
/// encodes.
class BackwardBitWriter {
 public:
  /// Starts a new stream of exactly `bits` bits that follow `before` other bits.
  void begin(size_t before, size_t bits) {
    shared_ = before & 7;
    const size_t all = shared_ + bits;
    size_ = (all + 7) / 8;
    if (bytes_.size() < kSlack + size_) bytes_.resize(kSlack + size_);
    end_ = bytes_.data() + kSlack + size_;
    hold_ = 0, held_ = static_cast<uint32_t>(-all & 7);
    put(0, 0);
  }

  /// bits: 0 to kMaxBits, value < 2^bits.
  static constexpr uint32_t kMaxBits = 56;
  void put(uint64_t value, uint32_t bits) {
    hold_ = hold_ << bits | value;
    held_ += bits;
    const uint64_t aligned = hold_ << (63 - held_) << 1;
    std::memcpy(end_ - sizeof aligned, &aligned, sizeof aligned);
    end_ -= held_ >> 3;
    held_ &= 7;
  }

  /// Appends all bytes to `out`. If the bits before end within a byte, that is the last one of
  /// `out`, and the first bits are added to it.
  void finish(std::vector<std::byte>& out) const {
    auto first = bytes_.begin() + kSlack;
    const auto last = first + static_cast<ptrdiff_t>(size_);
    if (shared_ > 0) out.back() |= *first++;
    out.insert(out.end(), first, last);
  }

 private:
  static constexpr size_t kSlack = 8;  ///< before the first byte, because put() writes whole words
  std::vector<std::byte> bytes_;
  size_t size_ = 0, shared_ = 0;
  std::byte* end_ = nullptr;  ///< the bytes from here on are final
  uint64_t hold_ = 0;
  uint32_t held_ = 0;
};

/// Reads the bits of a BitWriter and a BackwardBitWriter. Does not check bounds: 8 bytes from the
/// position on must be readable, and the caller must check bytes_read() regularly.
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

  /// Number of bytes read, the last one possibly in part.
  size_t bytes_read() const { return (position_ + 7) >> 3; }

  /// The byte after those counted by bytes_read().
  const uint8_t* position() const { return begin_ + bytes_read(); }

  /// Whether the unread bits of the last byte are zero.
  bool padding_is_zero() const {
    return BitReader(*this).get(static_cast<uint32_t>(-position_ & 7)) == 0;
  }

 private:
  const uint8_t* begin_;
  size_t position_ = 0;
};

}  // namespace isosplat
