#include "shared/import/tiff_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/checksums.h"
#include "shared/import/pack_bits.h"

namespace isosplat {
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
      return 1032;
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
      return inflate(in, out);
    case kPackBits:
      return expand_pack_bits(in, out);
    default:
      return false;
  }
}

Result<size_t> TiffRows::read_rest(std::span<uint8_t> into) {
  const size_t count = std::min(into.size(), rest_.size());
  std::copy_n(rest_.begin(), count, into.begin());
  rest_ = rest_.subspan(count);
  return count;
}

/// zlib's container (RFC 1950).
bool TiffRows::inflate(std::span<const uint8_t> in, std::span<uint8_t> out) {
  rest_ = in;
  deflate_.reset();
  const int method = deflate_.byte(), flags = deflate_.byte();
  if (flags < 0 || (method * 256 + flags) % 31 != 0 || (method & 15) != 8 || (flags & 32) != 0) {
    return false;
  }
  deflate_.begin({});
  uint32_t checksum = 1;
  for (size_t done = 0;;) {
    const auto stop = deflate_.run();
    const auto made = deflate_.made();
    const size_t count = std::min(made.size(), out.size() - done);
    std::copy_n(made.begin(), count, out.begin() + static_cast<std::ptrdiff_t>(done));
    if (count < made.size()) return true;
    checksum = adler32(checksum, made);
    done += made.size();
    deflate_.take(made.size());
    if (stop == DeflateDecoder::Stop::end) {
      uint32_t stored = 0;
      for (int i = 0; i < 4; ++i) stored = stored << 8 | static_cast<uint32_t>(deflate_.byte());
      return done == out.size() && stored == checksum;
    }
    if (stop != DeflateDecoder::Stop::full && stop != DeflateDecoder::Stop::block) return false;
  }
}

}  // namespace isosplat
