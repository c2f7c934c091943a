#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace isosplat::import {

/// Expands TIFF's LZW data (TIFF 6.0, section 13): codes of 9 to 12 bits, the highest bit first.
/// The code size grows one code earlier than necessary.
class TiffLzw {
 public:
  /// Expands until `out` is full, and ignores the rest. Returns false if the data end before, or
  /// are damaged.
  bool expand(std::span<const uint8_t> in, std::span<uint8_t> out);

 private:
  /// The string of a code from 258 on: the string of another code, and one more byte.
  struct String {
    uint16_t prefix;
    uint16_t length;
    uint8_t first, last;
  };
  std::array<String, 4096> strings_;
};

}  // namespace isosplat::import
