#include "shared/import/codecs/zlib_inflater.h"

#include <algorithm>

#include "shared/import/codecs/checksums.h"

namespace isosplat::import {

Result<size_t> ZlibInflater::read_rest(std::span<uint8_t> into) {
  const size_t count = std::min(into.size(), rest_.size());
  std::copy_n(rest_.begin(), count, into.begin());
  rest_ = rest_.subspan(count);
  return count;
}

ZlibInflater::Outcome ZlibInflater::inflate(std::span<const uint8_t> in, std::span<uint8_t> out) {
  rest_ = in;
  decoder_.reset();
  // Method 8, a multiple of 31, no dictionary.
  const int method = decoder_.byte(), flags = decoder_.byte();
  if (flags < 0 || (method * 256 + flags) % 31 != 0 || (method & 15) != 8 || (flags & 32) != 0) {
    return Outcome::failed;
  }
  decoder_.begin({});
  uint32_t checksum = 1;
  for (size_t done = 0;;) {
    const auto stop = decoder_.run();
    const auto made = decoder_.made();
    const size_t count = std::min(made.size(), out.size() - done);
    std::copy_n(made.begin(), count, out.begin() + static_cast<std::ptrdiff_t>(done));
    if (count < made.size()) return Outcome::surplus;
    checksum = adler32(checksum, made);
    done += made.size();
    decoder_.take(made.size());
    if (stop == DeflateDecoder::Stop::end) {
      uint32_t stored = 0;
      for (int i = 0; i < 4; ++i) stored = stored << 8 | static_cast<uint32_t>(decoder_.byte());
      return done == out.size() && stored == checksum ? Outcome::exact : Outcome::failed;
    }
    if (stop != DeflateDecoder::Stop::full && stop != DeflateDecoder::Stop::block) {
      return Outcome::failed;
    }
  }
}

}  // namespace isosplat::import
