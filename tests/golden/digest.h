#pragma once

#include <cstdio>
#include <string>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// CRC-32 as in zlib and PNG, which libraries of all languages provide.
class Crc32 {
 public:
  void add(uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      crc_ ^= value >> (8 * i) & 0xff;
      for (int bit = 0; bit < 8; ++bit) crc_ = crc_ >> 1 ^ (crc_ & 1 ? 0xedb88320u : 0);
    }
  }
  uint32_t value() const { return ~crc_; }

 private:
  uint32_t crc_ = 0xffffffff;
};

/// A digest of a store's decoded content: for each level a line "level chunks cells crc", where crc
/// is the CRC-32 (hexadecimal) over its chunks in directory order (page by page, block by block,
/// band by band) and their cells in raster order, each as x, y, z in the block (a byte each), eight
/// corners, min and max (16 bits each, little-endian).
inline std::string digest_of(std::span<const std::byte> store) {
  auto reader = StoreReader::open(store);
  if (!reader) return reader.error().message;
  for (uint32_t i = 0; i < reader->pages().size(); ++i) {
    const PageRef page = reader->pages()[i];
    const auto bytes = store.subspan(static_cast<size_t>(page.offset), page.bytes);
    if (auto added = reader->add_page(i, bytes); !added) return added.error().message;
  }
  std::string text;
  ChunkDecoder decoder;
  DecodedCells decoded;
  for (const LevelRef& level : reader->levels()) {
    Crc32 crc;
    unsigned long long cells = 0;
    const auto chunks = reader->chunks_for(level.grid.level, 0, 65535);
    for (const ChunkRef& chunk : *chunks) {
      const ChunkShape shape{block_cells(level.grid, chunk.block.index), chunk.band_begin,
                             chunk.band_end, chunk.cells, level.grid.level > 0};
      const auto bytes = store.subspan(static_cast<size_t>(chunk.offset), chunk.bytes);
      if (auto result = decoder.decode(bytes, shape, decoded); !result) {
        return result.error().message;
      }
      cells += decoded.cell.size();
      for (size_t i = 0; i < decoded.cell.size(); ++i) {
        for (const int shift : {0, 6, 12}) crc.add(decoded.cell[i] >> shift & 63, 1);
        for (const QuantizedValue corner : decoded.corners[i]) crc.add(corner, 2);
        crc.add(decoded.interval[i].min, 2);
        crc.add(decoded.interval[i].max, 2);
      }
    }
    char line[80];
    std::snprintf(line, sizeof line, "%u %u %llu %08x\n", level.grid.level,
                  static_cast<unsigned>(chunks->size()), cells, crc.value());
    text += line;
  }
  return text;
}

}  // namespace isosplat
