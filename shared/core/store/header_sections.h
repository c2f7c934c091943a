#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "shared/core/store/byte_order.h"
#include "shared/core/store/store_header.h"

// The sections VOLU, LEVL and PAGE of a store's header (FORMAT.md). The parsers read the payload
// after a section's header. Call them in the order of this file: each uses the results of those
// before it. The writers append a section with its header, without padding.
namespace isosplat {

/// The end of each error of a damaged header.
inline constexpr const char* kHeaderRemedy = ": rebuild the store, or fetch it again";

/// The error malformed_header. `what`: what was expected, and what was found.
tl::unexpected<Error> malformed_header(const std::string& what);

/// VOLU: grid, mapping, range and missing_voxels. Errors: malformed_header.
Result<void> parse_volume_section(std::span<const std::byte> payload, StoreInfo& info);
void write_volume_section(const StoreInfo& info, FieldWriter& to);

/// LEVL: page_log2, and the levels without first_page. Also sets info.levels and info.chunk_count.
/// Requires info.header_bytes, info.file_bytes and info.fields, which level 0 contains. Errors:
/// malformed_header.
Result<void> parse_levels_section(std::span<const std::byte> payload, StoreHeader& header);
void write_levels_section(const StoreHeader& header, FieldWriter& to);

/// PAGE: the pages. Also sets first_page of each level. Errors: malformed_header.
Result<void> parse_pages_section(std::span<const std::byte> payload, StoreHeader& header);
void write_pages_section(const StoreHeader& header, FieldWriter& to);

}  // namespace isosplat
