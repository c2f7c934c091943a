#pragma once

#include <span>
#include <vector>

#include "shared/core/store/store_reader.h"

namespace isosplat {

/// A parsed header of a store. It is consistent: levels and pages match the volume's dimensions and
/// tile the file, and every offset lies within the file.
struct StoreHeader {
  StoreInfo info;
  uint32_t page_log2 = 0;  ///< a page describes 2^page_log2 blocks along each axis
  std::vector<LevelRef> levels;
  std::vector<PageRef> pages;
};

/// Errors: as StoreReader::open.
Result<StoreHeader> parse_store_header(std::span<const std::byte> bytes);

/// The bytes of a header: exactly info.header_bytes, padded with zeros before the checksum. Writes
/// info.content_id unchanged. Errors: invalid_argument if they do not fit.
Result<std::vector<std::byte>> write_store_header(const StoreHeader& header);

/// The smallest header_bytes for a volume with this much metadata, without fields.
size_t header_bytes_for(Index3 voxels, uint32_t page_log2, size_t metadata_bytes);

/// The pages of a store in file order, with level and box only.
std::vector<PageRef> list_pages(Index3 voxels, uint32_t page_log2);

}  // namespace isosplat
