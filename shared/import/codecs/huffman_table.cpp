#include "shared/import/codecs/huffman_table.h"

#include <algorithm>

namespace isosplat::import {
namespace {

constexpr unsigned kMaxBits = 15;

// RFC 1951, 3.2.5: base values of the symbols from 257 on, and of the distances.
constexpr uint16_t kLengthBase[29] = {3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                      15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                      67, 83, 99, 115, 131, 163, 195, 227, 258};
constexpr uint8_t kLengthExtra[29] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                      2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0};
constexpr uint16_t kDistanceBase[30] = {
    1,   2,   3,   4,   5,   7,    9,    13,   17,   25,   33,   49,   65,    97,    129,
    193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};

uint32_t entry_of(HuffmanTable::Kind kind, size_t symbol, unsigned bits) {
  uint32_t what = HuffmanTable::kInvalid, value = 0;
  if (kind == HuffmanTable::Kind::code_lengths ||
      (kind == HuffmanTable::Kind::literals && symbol < 256)) {
    what = HuffmanTable::kLiteral;
    value = static_cast<uint32_t>(symbol);
  } else if (kind == HuffmanTable::Kind::literals && symbol == 256) {
    what = HuffmanTable::kEndOfBlock;
  } else if (kind == HuffmanTable::Kind::literals && symbol - 257 < std::size(kLengthBase)) {
    what = kLengthExtra[symbol - 257];
    value = kLengthBase[symbol - 257];
  } else if (kind == HuffmanTable::Kind::distances && symbol < std::size(kDistanceBase)) {
    what = symbol < 4 ? 0 : static_cast<uint32_t>(symbol / 2 - 1);
    value = kDistanceBase[symbol];
  }
  return value << 16 | what << 8 | bits;
}

uint32_t reversed(uint32_t code, unsigned bits) {
  uint32_t out = 0;
  for (unsigned i = 0; i < bits; ++i) out |= (code >> i & 1) << (bits - 1 - i);
  return out;
}

}  // namespace

bool HuffmanTable::build(Kind kind, std::span<const uint8_t> lengths) {
  root_bits_ = kind == Kind::code_lengths ? 7 : kind == Kind::literals ? 10 : 8;
  std::array<unsigned, kMaxBits + 1> count{};
  for (const uint8_t bits : lengths) ++count[bits];
  count[0] = 0;
  int unused = 1;
  unsigned longest = 0;
  for (unsigned bits = 1; bits <= kMaxBits; ++bits) {
    unused = unused * 2 - static_cast<int>(count[bits]);
    if (unused < 0) return false;
    if (count[bits] > 0) longest = bits;
  }
  if (unused > 0 && (kind == Kind::code_lengths || longest > 1)) return false;

  const size_t root_size = size_t{1} << root_bits_;
  std::fill_n(entries_.begin(), root_size, uint32_t{kInvalid} << 8 | 1);
  size_t used = root_size, table_begin = 0;
  unsigned table_bits = 0;
  uint32_t code = 0, prefix = UINT32_MAX;
  for (unsigned bits = 1; bits <= longest; ++bits, code <<= 1) {
    for (size_t symbol = 0; symbol < lengths.size(); ++symbol) {
      if (lengths[symbol] != bits) continue;
      const uint32_t entry = entry_of(kind, symbol, bits);
      const uint32_t index = reversed(code, bits);
      if (bits <= root_bits_) {
        for (size_t i = index; i < root_size; i += size_t{1} << bits) entries_[i] = entry;
      } else {
        const uint32_t low = index & static_cast<uint32_t>(root_size - 1);
        if (low != prefix) {
          // Codes are in ascending order: this one begins a table, which has space for all codes
          // with this prefix.
          prefix = low;
          table_bits = bits - root_bits_;
          int room = 1 << table_bits;
          while (table_bits + root_bits_ < longest) {
            room -= static_cast<int>(count[table_bits + root_bits_]);
            if (room <= 0) break;
            ++table_bits;
            room *= 2;
          }
          table_begin = used;
          used += size_t{1} << table_bits;
          if (used > entries_.size()) return false;
          std::fill(entries_.begin() + static_cast<std::ptrdiff_t>(table_begin),
                    entries_.begin() + static_cast<std::ptrdiff_t>(used),
                    uint32_t{kInvalid} << 8 | bits);
          entries_[low] = static_cast<uint32_t>(table_begin) << 16 |
                          static_cast<uint32_t>(kTable + table_bits) << 8 | root_bits_;
        }
        for (size_t i = index >> root_bits_; i < size_t{1} << table_bits;
             i += size_t{1} << (bits - root_bits_)) {
          entries_[table_begin + i] = entry;
        }
      }
      --count[bits];
      ++code;
    }
  }
  return true;
}

}  // namespace isosplat::import
