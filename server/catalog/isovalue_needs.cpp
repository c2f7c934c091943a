#include "server/catalog/isovalue_needs.h"

#include <algorithm>
#include <numeric>

namespace isosplat::server {

std::vector<IsovalueNeeds> isovalue_needs(std::span<const double> isovalues,
                                          const ValueMapping& mapping,
                                          std::span<const ChunkRef> chunks) {
  // The isovalues that need a chunk are consecutive in ascending order. The chunk is added at the
  // first one and subtracted after the last one, and prefix sums give the needs of each isovalue.
  std::vector<float> quantized;
  for (const double isovalue : isovalues) {
    quantized.push_back(mapping.quantized_isovalue(isovalue));
  }
  std::vector<size_t> order(isovalues.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::sort(order, {}, [&](size_t i) { return quantized[i]; });
  struct Change {
    uint64_t chunks = 0, bytes = 0, cells = 0;  // modulo 2^64
  };
  std::vector<Change> changes(isovalues.size() + 1);
  const auto first_from = [&](float bound) {
    return static_cast<size_t>(
        std::ranges::lower_bound(order, bound, {}, [&](size_t i) { return quantized[i]; }) -
        order.begin());
  };
  for (const ChunkRef& chunk : chunks) {
    if (chunk.cells == 0) continue;
    Change& begin = changes[first_from(static_cast<float>(chunk.band_begin))];
    begin.chunks += 1;
    begin.bytes += chunk.bytes;
    begin.cells += chunk.cells;
    Change& end = changes[first_from(static_cast<float>(chunk.band_end))];
    end.chunks -= 1;
    end.bytes -= chunk.bytes;
    end.cells -= chunk.cells;
  }
  std::vector<IsovalueNeeds> needs(isovalues.size());
  Change sum;
  for (size_t i = 0; i < order.size(); ++i) {
    sum.chunks += changes[i].chunks;
    sum.bytes += changes[i].bytes;
    sum.cells += changes[i].cells;
    needs[order[i]] = {isovalues[order[i]], sum.chunks, sum.bytes, sum.cells};
  }
  return needs;
}

}  // namespace isosplat::server
