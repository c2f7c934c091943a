#pragma once

#include <span>
#include <vector>

#include "shared/core/store/store_reader.h"

namespace isosplat {

/// A parsed directory page.
struct DirectoryPage {
  struct Block {
    uint64_t offset;  ///< of its first chunk, in the file; the others follow
    CellInterval interval;
    uint32_t first_chunk;  ///< in chunks
    uint32_t band_count;
  };
  struct Chunk {
    uint32_t checksum;
    uint32_t bytes;
    uint32_t cells;
    uint16_t band_end;
  };
  std::vector<Block> blocks;  ///< of the page's box, x fastest
  std::vector<Chunk> chunks;  ///< block by block, bands ascending
};

/// Parses the bytes of a page. Checks that the checksum matches, that each block's bands tile its
/// interval, that intervals lie within the page's interval, and that the chunks are in file order
/// and within the level's byte range.
/// Errors: truncated, checksum_mismatch, malformed_page.
Result<DirectoryPage> parse_page(std::span<const std::byte> bytes, const PageRef& page,
                                 const LevelRef& level);

/// The bytes of a page. Requires a page that parse_page accepts.
std::vector<std::byte> write_page(const DirectoryPage& page);

}  // namespace isosplat
