#pragma once

#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// Opens a field of a store: info().fields[field]. It has the chunk addresses of the store; its
/// chunks are field chunks. Its path(), which begins messages, is that of the store with the name
/// of the field: "flow.isosplat, field 'pressure'". directory_bytes: as in StoreFile::open. Errors:
/// those of StoreFile::open; malformed_header also if its grid, mapping or pages are not those of
/// the store, or its description is not the one that the store lists.
Result<std::shared_ptr<StoreFile>> open_field(const StoreFile& store, size_t field,
                                              uint64_t directory_bytes = uint64_t{256} << 20);

/// The index of the field with this name. Errors: not_found, with the names of the fields.
Result<size_t> find_field(const StoreInfo& store, const std::string& name);

}  // namespace isosplat
