#pragma once

#include <cstdint>
#include <span>

#include "shared/import/codecs/deflate_decoder.h"

namespace isosplat::import {

/// Decompresses zlib data (RFC 1950) in memory. Keeps its working memory between calls.
class ZlibInflater {
 public:
  enum class Outcome : uint8_t {
    failed,  ///< the data are damaged, or do not fill `out`
    exact,   ///< the data fill `out` exactly, and their checksum is correct
    surplus  ///< the data continue beyond `out`, so no checksum was compared
  };

  ZlibInflater() = default;
  ZlibInflater(const ZlibInflater&) = delete;
  ZlibInflater& operator=(const ZlibInflater&) = delete;

  Outcome inflate(std::span<const uint8_t> in, std::span<uint8_t> out);

 private:
  Result<size_t> read_rest(std::span<uint8_t> into);

  std::span<const uint8_t> rest_;  ///< that decoder_ has not read
  DeflateDecoder decoder_{[this](std::span<uint8_t> into) { return read_rest(into); }};
};

/// The maximum number of bytes that one byte of deflated data expands to.
constexpr uint64_t kMostDeflateExpansion = 1032;

}  // namespace isosplat::import
