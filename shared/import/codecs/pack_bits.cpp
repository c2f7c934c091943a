#include "shared/import/codecs/pack_bits.h"

#include <algorithm>

namespace isosplat::import {

// 0 … 127: n + 1 bytes follow; 129 … 255: the next byte, 257 − n times; 128: nothing.
bool expand_pack_bits(std::span<const uint8_t> in, std::span<uint8_t> out) {
  while (!out.empty()) {
    if (in.size() < 2) return false;
    const uint8_t head = in[0];
    in = in.subspan(1);
    if (head == 128) continue;
    const bool repeats = head > 128;
    const size_t length = repeats ? 257u - head : head + 1u, count = std::min(length, out.size());
    if (repeats) {
      std::fill_n(out.begin(), count, in[0]);
    } else {
      if (in.size() < count) return false;
      std::copy_n(in.begin(), count, out.begin());
    }
    in = in.subspan(repeats ? 1 : std::min(length, in.size()));
    out = out.subspan(count);
  }
  return true;
}

}  // namespace isosplat::import
