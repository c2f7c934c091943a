#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "shared/import/deflate_decoder.h"
#include "shared/import/tiff_lzw.h"

namespace isosplat {

/// Expands the bytes of strips and tiles.
class TiffRows {
 public:
  /// How many bytes one compressed byte becomes at most; 0: the compression (tag 259) is not known
  /// here.
  static uint64_t max_expansion(uint64_t compression);

  /// A compression in words.
  static std::string describe(uint64_t compression);

  /// Expands until `out` is full. What follows is ignored, as libtiff does. False if the data end
  /// before, or are damaged.
  bool expand(uint64_t compression, std::span<const uint8_t> in, std::span<uint8_t> out);

 private:
  bool inflate(std::span<const uint8_t> in, std::span<uint8_t> out);

  TiffLzw lzw_;
  std::span<const uint8_t> rest_;  ///< that deflate_ has not read
  DeflateDecoder deflate_{[this](std::span<uint8_t> into) { return read_rest(into); }};

  Result<size_t> read_rest(std::span<uint8_t> into);
};

}  // namespace isosplat
