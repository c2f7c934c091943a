#pragma once

#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// Opens a field of a store: info().fields[field]. It has the chunk addresses of the store; its
/// chunks are field chunks. Errors: those of StoreFile::open; malformed_header also if its grid or
/// mapping is not that of the store.
Result<std::shared_ptr<StoreFile>> open_field(const StoreFile& store, size_t field);

/// The index of the field with this name. Errors: not_found, with the names of the fields.
Result<size_t> find_field(const StoreInfo& store, const std::string& name);

}  // namespace isosplat
