#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace isosplat::import {

/// A table that decodes a Huffman code of RFC 1951 (3.2.2), whose bits come lowest first. The low
/// root_bits of the input are the index of an entry: either of a symbol, or of a second table for
/// longer codes.
///
///     bit   31..16  15..8  7..0
///           value   kind   bits
///
/// kind: 0 to 15 extra bits after a base value; kLiteral; kEndOfBlock; kInvalid; kTable + the
/// number of its index bits. bits: of the code (of kTable: root_bits).
class HuffmanTable {
 public:
  static constexpr uint8_t kLiteral = 32, kEndOfBlock = 33, kInvalid = 34, kTable = 64;

  enum class Kind : uint8_t { code_lengths, literals, distances };

  /// Builds the table for a code with these lengths per symbol, 0 to 15 bits. Returns false if the
  /// lengths are invalid: over-subscribed, or incomplete (except a single code of one bit).
  bool build(Kind kind, std::span<const uint8_t> lengths);

  /// The entry of the code at the beginning of `bits`, of which at least 15 are needed.
  uint32_t find(uint64_t bits) const {
    const uint32_t entry = entries_[static_cast<size_t>(bits) & ((size_t{1} << root_bits_) - 1)];
    const uint32_t kind = entry >> 8 & 0xff;
    if (kind < kTable) return entry;
    const size_t index =
        static_cast<size_t>(bits >> root_bits_) & ((size_t{1} << (kind - kTable)) - 1);
    return entries_[(entry >> 16) + index];
  }

 private:
  static constexpr size_t kMaxEntries = 2048;

  unsigned root_bits_ = 0;
  std::array<uint32_t, kMaxEntries> entries_;
};

}  // namespace isosplat::import
