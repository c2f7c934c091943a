// Hostile chunks: any bytes decode to the number of cells that the directory states, or to an
// error. Both decoding functions give the same result. The same for field chunks.
#include <cstdlib>

#include "shared/core/codec/cell_mask.h"
#include "shared/core/codec/chunk_codec.h"
#include "tests/fuzz/edits.h"
#include "tests/shared/store_fixture.h"

namespace isosplat {
namespace {

struct ValidChunk {
  ChunkShape shape;
  std::vector<std::byte> bytes;
  std::vector<uint32_t> cells;
  std::vector<std::byte> field;  ///< a field chunk of these cells
};

/// Chunks of two levels, with smooth and rough data, and with narrow and wide bands.
std::vector<ValidChunk> make_chunks() {
  constexpr Index3 kVoxels{14, 11, 8};
  std::vector<ValidChunk> chunks;
  ChunkEncoder encoder;
  ChunkDecoder decoder;
  for (const int scale : {1, 200}) {
    const auto levels = fixture::make_levels(kVoxels, [&](int32_t x, int32_t y, int32_t z) {
      return static_cast<QuantizedValue>(scale * fixture::rough_ball(kVoxels, x, y, z) % 65535);
    });
    for (const fixture::Level& level : levels) {
      const bool has_intervals = level.grid.level > 0;
      const BlockVoxels view{level.grid.cells, level.voxels.data(), level.intervals.data(),
                             has_intervals};
      for (const auto& [begin, end] : {std::pair{0u, 65536u}, std::pair{40u, 60u}}) {
        ValidChunk chunk;
        const uint32_t cells = encoder.encode(view, begin, end, chunk.bytes);
        if (cells == 0) continue;
        chunk.shape = {level.grid.cells, begin, end, cells, has_intervals};
        DecodedCells decoded;
        CellMask mask;
        if (!decoder.decode(chunk.bytes, chunk.shape, decoded)) std::abort();
        if (!mask.set(decoded.cell, level.grid.cells)) std::abort();
        chunk.cells = decoded.cell;
        encoder.encode_field(view, mask, 65536, chunk.field);
        chunks.push_back(std::move(chunk));
      }
    }
  }
  return chunks;
}

void decode(std::span<const std::byte> bytes, const ChunkShape& shape) {
  static ChunkDecoder decoder;
  static DecodedCells cells;
  static std::vector<PackedSample> samples;
  const auto decoded = decoder.decode(bytes, shape, cells);
  const auto packed = decoder.decode_packed(bytes, shape, samples);
  if (decoded.has_value() != packed.has_value()) std::abort();
  if (!decoded) return;
  if (cells.cell.size() != shape.cell_count || cells.corners.size() != shape.cell_count ||
      cells.interval.size() != shape.cell_count || samples.size() != shape.cell_count) {
    std::abort();
  }
  for (size_t i = 0; i < shape.cell_count; ++i) {
    const uint32_t cell = cells.cell[i];
    const Index3 place{int32_t(cell & 63), int32_t(cell >> 6 & 63), int32_t(cell >> 12)};
    if (place.x >= shape.block_cells.x || place.y >= shape.block_cells.y ||
        place.z >= shape.block_cells.z) {
      std::abort();
    }
    if (samples[i] != pack_sample(place, cells.interval[i], cells.corners[i])) std::abort();
  }
}

void decode_field(std::span<const std::byte> bytes, Index3 block_cells,
                  std::span<const uint32_t> cells, uint32_t value_end) {
  static ChunkDecoder decoder;
  static std::vector<CellCorners> corners;
  const auto decoded = decoder.decode_field(bytes, block_cells, cells, value_end, corners);
  if (corners.size() != (decoded ? cells.size() : 0)) std::abort();
}

}  // namespace
}  // namespace isosplat

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  static const std::vector<ValidChunk> chunks = make_chunks();
  fuzz::Input input(data, size);
  const uint32_t which = input.number(1);
  if (which & 0x80) {
    ChunkShape shape;
    shape.block_cells = {int32_t(input.number(1) % 65), int32_t(input.number(1) % 65),
                         int32_t(input.number(1) % 65)};
    shape.band_begin = input.number(2);
    shape.band_end = input.number(3) % 65537;
    shape.cell_count = input.number(3) % 300000;
    shape.has_intervals = which & 1;
    if (which & 2) {
      std::vector<uint32_t> cells;
      for (uint32_t n = input.number(1), cell = 0; n > 0; --n) {
        cells.push_back(cell += input.number(2));
      }
      decode_field(input.rest(), shape.block_cells, cells, shape.band_end);
      return 0;
    }
    decode(input.rest(), shape);
    return 0;
  }
  ValidChunk chunk = chunks[(which & 0x1f) % chunks.size()];
  if (which & 0x20) {
    if (which & 0x40) chunk.field.resize(chunk.field.size() - input.number(2) % chunk.field.size());
    edit(chunk.field, input);
    decode_field(chunk.field, chunk.shape.block_cells, chunk.cells, 65536);
    return 0;
  }
  if (which & 0x40) chunk.bytes.resize(chunk.bytes.size() - input.number(2) % chunk.bytes.size());
  edit(chunk.bytes, input);
  decode(chunk.bytes, chunk.shape);
  return 0;
}
