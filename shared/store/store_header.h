#pragma once

#include <span>
#include <vector>

#include "shared/store/store_reader.h"

namespace isosplat {

/// A store's header, parsed. All of it is consistent: levels and pages are those that the volume's
/// dimensions demand, they tile the file, and no offset leaves it.
struct StoreHeader {
  StoreInfo info;
  uint32_t page_log2 = 0;  ///< a page describes 2^page_log2 blocks along each axis
  std::vector<LevelRef> levels;
  std::vector<PageRef> pages;
};

/// Errors: as StoreReader::open.
Result<StoreHeader> parse_store_header(std::span<const std::byte> bytes);

/// The bytes of a header: exactly info.header_bytes of them, with their checksum, padded with
/// zeros. Writes info.content_id as it is. Errors: invalid_argument where they do not fit.
Result<std::vector<std::byte>> write_store_header(const StoreHeader& header);

/// The smallest header_bytes for a volume with this much metadata.
size_t header_bytes_for(Index3 voxels, uint32_t page_log2, size_t metadata_bytes);

/// The page list of a store without sizes: level, box, in file order.
std::vector<PageRef> list_pages(Index3 voxels, uint32_t page_log2);

}  // namespace isosplat
