#pragma once

#include <span>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/sampling/packed_field.h"

namespace isosplat {

/// Decodes a field chunk for the GPU. `samples`: all samples of the chunk that it belongs to, in
/// any order. `value_end`: above all values, 256 or 65536. Replaces the content of `out` by one
/// item for each sample, in their order; after an error it is empty. Errors: those of
/// ChunkDecoder::decode_field; invalid_argument also where two samples are of one cell.
Result<void> decode_field_samples(ChunkDecoder& decoder, std::span<const std::byte> bytes,
                                  Index3 block_cells, std::span<const PackedSample> samples,
                                  uint32_t value_end, std::vector<PackedField>& out);

}  // namespace isosplat
