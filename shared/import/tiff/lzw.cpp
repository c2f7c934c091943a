#include "shared/import/tiff/lzw.h"

#include <algorithm>

namespace isosplat::import {
namespace {

constexpr uint32_t kClear = 256, kEnd = 257, kFirstCode = 258, kCodes = 4096;

}  // namespace

bool TiffLzw::expand(std::span<const uint8_t> in, std::span<uint8_t> out) {
  for (uint16_t i = 0; i < 256; ++i) {
    strings_[i] = {0, 1, static_cast<uint8_t>(i), static_cast<uint8_t>(i)};
  }
  uint32_t next = kFirstCode, bits = 9, before = kClear;
  uint32_t hold = 0, held = 0;
  size_t at = 0, done = 0;
  while (done < out.size()) {
    for (; held < bits; held += 8) {
      if (at == in.size()) return false;
      hold = hold << 8 | in[at++];
    }
    held -= bits;
    const uint32_t code = hold >> held & ((1u << bits) - 1);
    if (code == kEnd) return false;
    if (code == kClear) {
      next = kFirstCode;
      bits = 9;
      before = kClear;
      continue;
    }
    if (before == kClear) {
      if (code > 255) return false;
    } else {
      // The code may be that of the string which begins with the previous one, and is known now.
      if (code > next || (code == next && next == kCodes)) return false;
      if (next < kCodes) {
        const String& start = strings_[before];
        const uint8_t last = code == next ? start.first : strings_[code].first;
        strings_[next] = {static_cast<uint16_t>(before), static_cast<uint16_t>(start.length + 1),
                          start.first, last};
        ++next;
        if (next + 1 == 1u << bits && bits < 12) ++bits;
      }
    }
    // Strings are written from their ends; bytes beyond the output are left out.
    const size_t length = strings_[code].length, room = out.size() - done;
    uint32_t part = code;
    for (size_t i = length; i-- > 0; part = strings_[part].prefix) {
      if (i < room) out[done + i] = strings_[part].last;
    }
    done += std::min(length, room);
    before = code;
  }
  return true;
}

}  // namespace isosplat::import
