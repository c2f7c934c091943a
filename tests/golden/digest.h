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

/// The bytes of a store or a field, with a reader that has all its pages.
struct WholeStore {
  std::span<const std::byte> bytes;
  StoreReader reader;

  static Result<WholeStore> open(std::span<const std::byte> bytes, StoreKind kind) {
    auto reader = StoreReader::open(bytes, kind);
    if (!reader) return tl::unexpected(reader.error());
    for (uint32_t i = 0; i < reader->pages().size(); ++i) {
      const PageRef page = reader->pages()[i];
      const auto of_page = bytes.subspan(static_cast<size_t>(page.offset), page.bytes);
      if (auto added = reader->add_page(i, of_page); !added) return tl::unexpected(added.error());
    }
    return WholeStore{bytes, std::move(*reader)};
  }

  std::span<const std::byte> chunk(const ChunkRef& chunk) const {
    return bytes.subspan(static_cast<size_t>(chunk.offset), chunk.bytes);
  }
};

/// A line "level chunks cells crc" for each level, where visit(level, chunk, crc) adds a chunk to
/// the CRC and returns its number of cells.
template <class Visit>
Result<std::string> digest_lines(const StoreReader& reader, Visit visit) {
  std::string text;
  for (const LevelRef& level : reader.levels()) {
    Crc32 crc;
    unsigned long long cells = 0;
    const auto chunks = reader.chunks_for(level.grid.level, 0, 65535);
    for (const ChunkRef& chunk : *chunks) {
      const auto of_chunk = visit(level, chunk, crc);
      if (!of_chunk) return tl::unexpected(of_chunk.error());
      cells += *of_chunk;
    }
    char line[80];
    std::snprintf(line, sizeof line, "%u %u %llu %08x\n", level.grid.level,
                  static_cast<unsigned>(chunks->size()), cells, crc.value());
    text += line;
  }
  return text;
}

/// A digest of a store's decoded content: for each level a line "level chunks cells crc", where crc
/// is the CRC-32 (hexadecimal) over its chunks in directory order (page by page, block by block,
/// band by band) and their cells in raster order, each as x, y, z in the block (a byte each), eight
/// corners, min and max (16 bits each, little-endian). Then for each field a line with its name,
/// and the same lines, whose crc is over the eight corners only.
inline Result<std::string> try_digest(std::span<const std::byte> bytes) {
  const auto store = WholeStore::open(bytes, StoreKind::store);
  if (!store) return tl::unexpected(store.error());
  ChunkDecoder decoder;
  DecodedCells decoded;
  const auto decode = [&](const LevelRef& level, const ChunkRef& chunk) {
    const ChunkShape shape{block_cells(level.grid, chunk.block.index), chunk.band_begin,
                           chunk.band_end, chunk.cells, level.grid.level > 0};
    return decoder.decode(store->chunk(chunk), shape, decoded);
  };
  auto text =
      digest_lines(store->reader,
                   [&](const LevelRef& level, const ChunkRef& chunk, Crc32& crc) -> Result<size_t> {
                     if (auto result = decode(level, chunk); !result)
                       return tl::unexpected(result.error());
                     for (size_t i = 0; i < decoded.cell.size(); ++i) {
                       for (const int shift : {0, 6, 12}) crc.add(decoded.cell[i] >> shift & 63, 1);
                       for (const QuantizedValue corner : decoded.corners[i]) crc.add(corner, 2);
                       crc.add(decoded.interval[i].min, 2);
                       crc.add(decoded.interval[i].max, 2);
                     }
                     return decoded.cell.size();
                   });
  for (const FieldRef& ref : store->reader.info().fields) {
    if (!text) return text;
    const auto field = WholeStore::open(
        bytes.subspan(static_cast<size_t>(ref.offset), static_cast<size_t>(ref.bytes)),
        StoreKind::field);
    if (!field) return tl::unexpected(field.error());
    std::vector<CellCorners> corners;
    auto lines = digest_lines(
        store->reader,
        [&](const LevelRef& level, const ChunkRef& chunk, Crc32& crc) -> Result<size_t> {
          if (auto result = decode(level, chunk); !result) return tl::unexpected(result.error());
          const auto of_field = field->reader.chunk(chunk.block, chunk.band);
          if (!of_field) return tl::unexpected(of_field.error());
          auto result = decoder.decode_field(field->chunk(*of_field),
                                             block_cells(level.grid, chunk.block.index),
                                             decoded.cell, 1u << ref.info.mapping.bits, corners);
          if (!result) return tl::unexpected(result.error());
          for (const CellCorners& of_cell : corners) {
            for (const QuantizedValue corner : of_cell) crc.add(corner, 2);
          }
          return corners.size();
        });
    if (!lines) return lines;
    *text += ref.info.name + "\n" + *lines;
  }
  return text;
}

/// The digest, or the message of an error.
inline std::string digest_of(std::span<const std::byte> store) {
  const auto text = try_digest(store);
  return text ? *text : text.error().message;
}

}  // namespace isosplat
