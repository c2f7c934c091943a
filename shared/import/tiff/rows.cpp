#include "shared/import/tiff/rows.h"

#include <fmt/format.h>

#include "shared/import/codecs/pack_bits.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kNone = 1, kLzw = 5, kDeflate = 8, kOldDeflate = 32946, kPackBits = 32773;

}  // namespace

uint64_t TiffRows::max_expansion(uint64_t compression) {
  switch (compression) {
    case kNone:
      return 1;
    case kLzw:
      return 2560;  // the longest string, 3838 bytes, of a code of 12 bits
    case kDeflate:
    case kOldDeflate:
      return kMostDeflateExpansion;
    case kPackBits:
      return 64;
    default:
      return 0;
  }
}

std::string TiffRows::describe(uint64_t compression) {
  const auto known = [&](const char* name) {
    return fmt::format("{} compression ({})", name, compression);
  };
  switch (compression) {
    case 6:
    case 7:
      return known("JPEG");
    case 34887:
      return known("LERC");
    case 34925:
      return known("LZMA");
    case 50000:
      return known("Zstandard");
    case 50001:
      return known("WebP");
    default:
      return fmt::format("compression {}", compression);
  }
}

bool TiffRows::expand(uint64_t compression, std::span<const uint8_t> in, std::span<uint8_t> out) {
  switch (compression) {
    case kLzw:
      return lzw_.expand(in, out);
    case kDeflate:
    case kOldDeflate:
      return zlib_.inflate(in, out) != ZlibInflater::Outcome::failed;
    case kPackBits:
      return expand_pack_bits(in, out);
    default:
      return false;
  }
}

}  // namespace isosplat::import
