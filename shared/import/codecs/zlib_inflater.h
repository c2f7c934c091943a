#pragma once

#include <cstdint>
#include <span>

#include "shared/import/codecs/deflate_decoder.h"

namespace isosplat::import {

/// Decompresses zlib data (RFC 1950) that are in memory. It keeps the memory that this needs.
class ZlibInflater {
 public:
  enum class Outcome : uint8_t {
    failed,  ///< the data are damaged, or do not fill `out`
    exact,   ///< the data fill `out`, and have the right checksum
    surplus  ///< the data fill `out`, and go on: there was no checksum to compare
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

/// How many bytes one byte of deflated data becomes at most.
constexpr uint64_t kMostDeflateExpansion = 1032;

}  // namespace isosplat::import
