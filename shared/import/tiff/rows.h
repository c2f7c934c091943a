#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "shared/import/codecs/zlib_inflater.h"
#include "shared/import/tiff/lzw.h"

namespace isosplat::import {

/// Expands the bytes of strips and tiles.
class TiffRows {
 public:
  /// The maximum expansion of one compressed byte, in bytes; 0 if this compression (tag 259) is not
  /// supported here.
  static uint64_t max_expansion(uint64_t compression);

  /// A compression in words.
  static std::string describe(uint64_t compression);

  /// Expands until `out` is full, and ignores the rest, as libtiff does. Returns false if the data
  /// end before, or are damaged.
  bool expand(uint64_t compression, std::span<const uint8_t> in, std::span<uint8_t> out);

 private:
  TiffLzw lzw_;
  ZlibInflater zlib_;
};

}  // namespace isosplat::import
