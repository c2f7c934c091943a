#pragma once

#include <cstddef>
#include <span>

#include "shared/core/store/byte_order.h"
#include "shared/core/store/store_reader.h"

// The sections of a store's header that concern fields (FORMAT.md): flds lists the fields of a
// store, FIEL describes the field whose values a file holds.
namespace isosplat {

/// Whether a field has a valid name, mapping and range. Errors: invalid_argument.
Result<void> check_field(const FieldInfo& field);

/// The bytes that the sections of info.fields and info.field add to a header; 0 without them.
/// Depends on the number of fields and their names.
size_t field_sections_bytes(const StoreInfo& info);

/// flds: the fields, with their offsets. Requires info.header_bytes. Errors: malformed_header.
Result<void> parse_field_list(std::span<const std::byte> payload, StoreInfo& info);
/// FIEL. Errors: malformed_header.
Result<void> parse_own_field(std::span<const std::byte> payload, StoreInfo& info);

/// Appends the sections with their headers, padded; nothing without fields.
void write_field_sections(const StoreInfo& info, FieldWriter& to);

}  // namespace isosplat
