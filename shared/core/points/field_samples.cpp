#include "shared/core/points/field_samples.h"

#include <algorithm>
#include <numeric>

namespace isosplat {

Result<void> decode_field_samples(ChunkDecoder& decoder, std::span<const std::byte> bytes,
                                  Index3 block_cells, std::span<const PackedSample> samples,
                                  uint32_t value_end, std::vector<PackedField>& out) {
  out.clear();
  // The low 18 bits of a sample are the index of its cell, by which a field chunk is ordered.
  const auto cell_of = [&](uint32_t sample) { return samples[sample].word[0] & ((1u << 18) - 1); };
  std::vector<uint32_t> order(samples.size()), cells(samples.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return cell_of(a) < cell_of(b); });
  std::transform(order.begin(), order.end(), cells.begin(), cell_of);
  std::vector<CellCorners> corners;
  auto decoded = decoder.decode_field(bytes, block_cells, cells, value_end, corners);
  if (!decoded) return decoded;
  out.resize(samples.size());
  for (size_t i = 0; i < order.size(); ++i) out[order[i]] = pack_field(corners[i]);
  return {};
}

}  // namespace isosplat
