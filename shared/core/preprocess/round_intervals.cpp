#include "shared/core/preprocess/round_intervals.h"

#include <algorithm>
#include <array>
#include <bit>

namespace isosplat {

void round_intervals(GatheredBlock& block) {
  constexpr int kMaxBits = 7;
  // Counts cells by the number of bits of their span. A span of b bits is at least 2^(b − 1).
  std::array<size_t, 17> cells{};
  for (const CellInterval interval : block.intervals) {
    const int span = std::max(interval.max - interval.min, 0);
    ++cells[static_cast<size_t>(std::bit_width(static_cast<unsigned>(span)))];
  }
  cells[0] = 0;  // never active
  size_t all = 0;
  for (const size_t count : cells) all += count;
  size_t below = 0;
  int bits = 0;
  while (bits < 16 && 5 * (below + cells[static_cast<size_t>(bits)]) <= all) {
    below += cells[static_cast<size_t>(bits++)];
  }
  const int shift = std::clamp(bits - 2, 0, kMaxBits);
  if (shift == 0) return;
  const auto low = static_cast<QuantizedValue>((1 << shift) - 1);
  for (CellInterval& interval : block.intervals) {
    if (interval.min >= interval.max) continue;
    interval.min = static_cast<QuantizedValue>(interval.min & ~low);
    interval.max = static_cast<QuantizedValue>(interval.max | low);
  }
}

}  // namespace isosplat
