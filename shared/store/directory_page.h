#pragma once

#include <span>
#include <vector>

#include "shared/store/store_reader.h"

namespace isosplat {

/// A directory page as the reader keeps it.
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

/// Parses and checks the bytes of a page: its checksum, that each block's bands tile its interval,
/// that intervals are within the page's, and that the chunks lie in file order within the level's.
/// Errors: truncated, checksum_mismatch, malformed_page.
Result<DirectoryPage> parse_page(std::span<const std::byte> bytes, const PageRef& page,
                                 const LevelRef& level);

/// The bytes of a page. Requires what parse_page checks.
std::vector<std::byte> write_page(const DirectoryPage& page);

}  // namespace isosplat
